// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of what acts along coordinates: its own, or by dual numbers.
#pragma once

#include <array>

#include "kinematics/model.h"
#include "math/dual.h"

namespace gelenk {

inline constexpr int most_inputs_along = dual_directions - 2;

// By q, v and the inputs, in the mechanism's sense. side: of the branch that it is held on, or null: on that of the
// state.
template <class F>
Dual::Directions derivatives_by_duals(const AlongCoordinate<F>& force, const double* q, const double* v,
                                      const double* u, int inputs, const int* side = nullptr) {
  std::array<Dual, most_inputs_along> input;
  for (int i = 0; i < inputs; ++i) {
    input[i] = Dual(u[force.input + i]);
    input[i].derivatives()[2 + i] = force.sign;  // as the effort in the mechanism's sense
  }
  Dual at(force.sign * q[force.q]);
  Dual speed(force.sign * v[force.v]);
  at.derivatives()[0] = speed.derivatives()[1] = 1;  // signs cancel
  if constexpr (HasBranches<F>) {
    return force.element.held(side == nullptr ? force.element.side(at, speed) : *side, at, speed).derivatives();
  } else {
    return force.element.effort(at, speed, input.data()).derivatives();
  }
}

}  // namespace gelenk
