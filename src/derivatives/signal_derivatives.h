// SPDX-License-Identifier: BSD-3-Clause
// Derivatives with respect to the signals that expressions name, and through the coordinates among them.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "derivatives/jacobians.h"
#include "kinematics/loads.h"
#include "math/dual.h"

namespace gelenk {

// What is read beyond the coordinates of the tree has derivatives by automatic differentiation only.
inline bool names_beyond_tree(const Loads& loads) {
  return std::ranges::any_of(
      loads.named, [](const NamedQuantity& of) { return of.reading != nullptr || (of.moves && of.cut >= 0); });
}

// Sets the derivatives of the rates of the element states that name no forces with respect to all signals, u.
inline void differentiate_states(const Loads& loads, const double* u, Jacobians& out) {
  for (int k = 0; k < loads.states(); ++k) {
    const Formula& rate = loads.rates[static_cast<std::size_t>(k)];
    if (rate.reads_forces()) continue;  // see formulation/rates_of_forces.h
    const std::span<const int> signals = rate.signals();
    std::array<Dual, Formula::max_signals> at;
    for (std::size_t i = 0; i < signals.size(); ++i) at[i] = Dual(u[signals[i]]);
    for (std::size_t first = 0; first < signals.size(); first += dual_directions) {
      const std::size_t width = std::min<std::size_t>(dual_directions, signals.size() - first);
      for (std::size_t i = 0; i < width; ++i) at[first + i].derivatives()[static_cast<Eigen::Index>(i)] = 1;
      const Dual value = rate.value<Dual>(nullptr, at.data());
      for (std::size_t i = 0; i < width; ++i) {
        out.rates_u(k, signals[first + i]) = value.derivatives()[static_cast<Eigen::Index>(i)];
        at[first + i].derivatives()[static_cast<Eigen::Index>(i)] = 0;
      }
    }
  }
}

// Adds the derivatives by coordinates of the tree that are signals to those by q and v.
inline void fold_coordinates(const Loads& loads, Jacobians& out) {
  const Eigen::Index nq = out.qdot_q.rows();
  Eigen::Index signal = loads.first_named();
  for (const NamedQuantity& of : loads.named) {
    const Eigen::Index column = of.is_rate ? nq + of.v : of.q;
    if (of.moves) {
      out.r.col(column) += of.sign * out.r_u.col(signal);
      if (loads.states() > 0) out.rates.col(column) += of.sign * out.rates_u.col(signal);
    }
    ++signal;
  }
}

}  // namespace gelenk
