// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of the forces along joint coordinates, by dual numbers.
#pragma once

#include <array>

#include "kinematics/force_modes.h"
#include "kinematics/loads.h"
#include "math/dual.h"

namespace gelenk {

// Maximum number of inputs of a force along a coordinate: two directions are taken by q and v.
inline constexpr int max_inputs_along = dual_directions - 2;

// Derivatives of the force with respect to q, v and its inputs, in the mechanism's sign. side: of the branch on which
// the force is held, or null for the branch of the state.
template <class F>
Dual::Directions derivatives_by_duals(const AlongCoordinate<F>& force, const double* q, const double* v,
                                      const double* u, int inputs, const int* side = nullptr) {
  std::array<Dual, max_inputs_along> input;
  for (int i = 0; i < inputs; ++i) {
    input[i] = Dual(u[force.input_at(i)]);
    input[i].derivatives()[2 + i] = force.sign;  // converts the effort to the mechanism's sign
  }
  Dual at(force.sign * q[force.q]);
  Dual speed(force.sign * v[force.v]);
  at.derivatives()[0] = speed.derivatives()[1] = 1;  // signs cancel
  if constexpr (Switches<F>) {
    const bool is_held = side != nullptr && *side != mode_of_state;
    return force.element.held(is_held ? *side : force.element.side(at, speed), at, speed, input.data()).derivatives();
  } else {
    return force.element.effort(at, speed, input.data()).derivatives();
  }
}

}  // namespace gelenk
