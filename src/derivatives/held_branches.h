// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "derivatives/jacobians.h"
#include "kinematics/coordinate_derivatives.h"

namespace gelenk {

// Replaces the derivatives of the forces along tree joints on the branches of the state by those on the held branches.
inline void differentiate_held(const Loads& loads, const int* side, const double* q, const double* v, const double* u,
                               Jacobians& out) {
  loads.tree.each_switching([&](const auto& force) {
    const int inputs = force.input_count();
    const auto held = derivatives_by_duals(force, q, v, u, inputs, side);
    const auto free = derivatives_by_duals(force, q, v, u, inputs);
    out.r_q()(force.v, force.q) += free[0] - held[0];
    out.r_v()(force.v, force.v) += free[1] - held[1];
    for (int i = 0; out.of_inputs && i < inputs; ++i) {
      const auto k = 2 + static_cast<std::size_t>(i);
      out.r_u(force.v, force.input_at(i)) += free[k] - held[k];
    }
    ++side;
  });
}

}  // namespace gelenk
