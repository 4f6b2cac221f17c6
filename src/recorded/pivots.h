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

// J at a position, of velocities and equations of size 1; what is rounding vanishes. M: nv x nv; J: rows x nv.
RowMatrix equilibrated(const Eigen::Ref<const RowMatrix>& M, RowMatrix J);

// Pivots that are large at all of these positions, the first of which is the start. rank: of J; equations beyond it are
// redundant, even where closure errors make them appear otherwise. usual: the position at which the pivots have their
// usual size; not changed if there is no equation.
Pivots choose_pivots(std::span<const RowMatrix> equilibrated_at, int rank, std::size_t& usual);

// Positions at which pivots are compared, before loops are closed there: the start, which may be a singular one, or
// near it, with pivots that are small or vanish; and some around it. The same ones at each call.
std::vector<std::vector<double>> positions_around(const std::vector<double>& start);

}  // namespace gelenk
