// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/rates_of_forces.h"

#include <algorithm>

namespace gelenk {

void RatesOfForces::add(const double* y, const double* vdot, const std::function<void(double* vdot)>& solve,
                        double* rates) {
  std::copy_n(vdot, vdot_.size(), vdot_.begin());
  const bool touches = contacts_.touches();
  if (touches) {  // so that reactions show their forces
    contacts_.apply_forces();
    solve(vdot_.data());
  }
  dynamics_.readings().set_root_poses();
  dynamics_.set_acceleration(vdot_.data());
  reader_->read(y, vdot_.data(), drives_.u().data(), modes_.outputs().present().data(),
                modes_.outputs().held_sides().data(), rates);
  if (touches) contacts_.withdraw_forces();
}

}  // namespace gelenk
