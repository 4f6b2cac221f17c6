// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of the forces along joint coordinates, by dual numbers.
#pragma once

#include <array>

#include "kinematics/force_modes.h"
#include "kinematics/loads.h"
#include "math/dual.h"

namespace gelenk {

// Maximum number of inputs of a force along a coordinate: two directions are taken by q and v.
inline constexpr int max_inputs_along = Formula::max_signals;

// Derivatives of a force along a coordinate with respect to q, v and its inputs.
using DerivativesAlong = std::array<double, 2 + max_inputs_along>;

// These, in the mechanism's sign. side: of the branch on which the force is held, or null for the branch of the state.
template <class F>
DerivativesAlong derivatives_by_duals(const AlongCoordinate<F>& force, const double* q, const double* v,
                                      const double* u, int inputs, const int* side = nullptr) {
  DerivativesAlong out{};
  std::array<Dual, 2 + max_inputs_along> at;
  at[0] = Dual(force.sign * q[force.q]);
  at[1] = Dual(force.sign * v[force.v]);
  for (int i = 0; i < inputs; ++i) at[2 + static_cast<std::size_t>(i)] = Dual(u[force.input_at(i)]);
  const auto effort = [&]() -> Dual {
    if constexpr (Switches<F>) {
      const bool is_held = side != nullptr && *side != mode_of_state;
      return force.element.held(is_held ? *side : force.element.side(at[0], at[1]), at[0], at[1], at.data() + 2);
    } else {
      return force.element.effort(at[0], at[1], at.data() + 2);
    }
  };
  const auto count = 2 + static_cast<std::size_t>(inputs);
  for (std::size_t first = 0; first < count; first += dual_directions) {
    const std::size_t width = std::min<std::size_t>(dual_directions, count - first);
    for (std::size_t k = 0; k < width; ++k) at[first + k].derivatives()[static_cast<Eigen::Index>(k)] = 1;
    const Dual found = effort();
    for (std::size_t k = 0; k < width; ++k) {
      const double by = found.derivatives()[static_cast<Eigen::Index>(k)];
      out[first + k] = first + k < 2 ? by : force.sign * by;  // signs of the coordinate and the effort cancel
      at[first + k].derivatives()[static_cast<Eigen::Index>(k)] = 0;
    }
  }
  return out;
}

}  // namespace gelenk
