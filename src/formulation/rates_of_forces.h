// SPDX-License-Identifier: BSD-3-Clause
// The rates of element states that name forces or accelerations, which are known when the accelerations are.
#pragma once

namespace gelenk {

class RatesOfForces {
 public:
  virtual ~RatesOfForces() = default;

  // Writes these rates to `rates`, by element state, and leaves the others. The dynamics are at y = (q, v, element
  // states), after set_acceleration(vdot) and set_root_poses(). u: the signals; forces, modes: of all forces with modes.
  virtual void read(const double* y, const double* vdot, const double* u, const double* forces, const int* modes,
                    double* rates) = 0;
};

}  // namespace gelenk
