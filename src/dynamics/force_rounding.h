// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// Rounding of the forces that keep coordinates at rest, in the last solve(), by lock (switching_forces.h).
class ForceRounding {
 public:
  // A holding force beyond its bound by less than this is rounding.
  virtual double slack(int lock) const = 0;
  // The force along its coordinate that alone would have an effect as large as all those in the last solve().
  virtual double largest_force(int lock) const = 0;

 protected:
  virtual ~ForceRounding() = default;
};

}  // namespace gelenk
