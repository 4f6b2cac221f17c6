// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// The equations of motion as the modes of contacts need them (touch_modes.h).
class TouchedEquations {
 public:
  // vdot (nv) at (t, y) in the present modes, without effect on the run; `dynamics` is left there.
  virtual void touched_accelerations(double t, const double* y, double* vdot) = 0;
  // Called when a mode has changed.
  virtual void touch_changed() = 0;

 protected:
  ~TouchedEquations() = default;
};

}  // namespace gelenk
