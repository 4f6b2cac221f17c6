// SPDX-License-Identifier: BSD-3-Clause
// Which constraint equations eliminate which velocities: chosen by numbers at some positions, for expressions in which
// the choice remains the same.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "derivatives/jacobians.h"

namespace gelenk {

// Constraint equations and the velocities that are eliminated by them, in this order.
struct Pivots {
  std::vector<int> rows, columns;

  friend bool operator==(const Pivots&, const Pivots&) = default;
};

// J at a position, of velocities and equations of size 1. M: nv x nv; J: rows x nv.
RowMatrix equilibrated(const Eigen::Ref<const RowMatrix>& M, RowMatrix J);

// Pivots that are large at all of these positions, the first of which is the start. usual: the position at which they
// have their usual size; not changed if there is no equation.
Pivots choose_pivots(std::span<const RowMatrix> equilibrated_at, std::size_t& usual);

// How far positions at which pivots are compared are from the start [rad or m]: that may be a singular one, or near it,
// with pivots that are small or vanish.
inline constexpr double pivot_neighborhoods[] = {0, 0.05, 0.05, 0.05, 0.2, 0.2, 0.2, 0.8, 0.8, 0.8};

}  // namespace gelenk
