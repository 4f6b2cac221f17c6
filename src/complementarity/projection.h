// SPDX-License-Identifier: BSD-3-Clause
// Projection onto the set of one cone (cone.h), and its generalized Jacobian. Both are exact for contacts with several
// limited groups, which are intersections of cones that share the normal component.
#pragma once

#include <array>

#include "complementarity/cone.h"

namespace gelenk {

// out <- the nearest point to y of the cone's set. y and out: cone.size() numbers; they may be the same.
void project(const Cone& cone, const double* y, double* out);

// The eigenvectors of an element J of the projection's generalized Jacobian at y that have positive eigenvalues:
// J = sum over k of lambda[k] q[k] q[k]^T, 0 < lambda[k] <= 1, with orthonormal q[k].
struct ProjectionModes {
  int count = 0;
  std::array<double, Cone::max_size> lambda{};
  std::array<std::array<double, Cone::max_size>, Cone::max_size> q{};
};
void projection_modes(const Cone& cone, const double* y, ProjectionModes& out);

// J itself, cone.size() squared numbers (it is symmetric).
void projection_jacobian(const Cone& cone, const double* y, double* out);

}  // namespace gelenk
