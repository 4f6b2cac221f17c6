// SPDX-License-Identifier: BSD-3-Clause
// How accurately the impulses of a time step are solved for: the residual of the relative velocities.
#pragma once

namespace gelenk {

struct ImpulseAccuracy {
  double relative = 0;  // to the largest of the relative velocities: solver.cone_tolerance
  double absolute = 0;  // [m/s] or [rad/s], of what moves; the larger one counts
};

}  // namespace gelenk
