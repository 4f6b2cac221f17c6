// SPDX-License-Identifier: BSD-3-Clause
// A given motion: a coordinate as a function of time, with its derivatives.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

class MotionLaw {
 public:
  static constexpr int orders = 5;  // the value and its first four derivatives
  using Derivatives = std::array<double, orders>;

  // motion: no input.
  explicit MotionLaw(const GivenMotion& motion);

  // s, s', s'', ... at t [s]; of a law that gives no more than the speed, s is 0.
  Derivatives at(double t) const;

 private:
  void make_spline();
  void add_spline(double t, Derivatives& out) const;

  GivenMotion motion_;
  std::vector<double> curvature_;  // s'' at the table's times
};

}  // namespace gelenk
