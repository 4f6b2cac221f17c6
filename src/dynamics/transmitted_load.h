// SPDX-License-Identifier: BSD-3-Clause
// A force of the mechanism that friction is proportional to, with its sign if it is along a line.
#pragma once

#include <array>

#include "kinematics/friction_loads.h"

namespace gelenk {

struct TransmittedLoad {
  FrictionLoad is;
  double factor = 0;                    // friction per size in the present motion, if it is a bearing's [m, 1]
  std::array<double, 2> losses{};       // the same of a mesh, at its present force
  std::array<double, 2> derivatives{};  // and the rate of its friction per size
  bool has_curved_losses = false;       // these differ: it depends on the force itself
  double speed = 0;                     // at which it slips
  std::array<double, 3> force{};
  std::array<double, 3> solved{};  // that of the last solve()
  std::array<double, 3> without_friction{};
  bool has_sign = false;  // it is along a line
  int held_sign = 0;      // 0: that of the force
  int sign_of_none = 0;   // that of a load of zero; 0: there is one
  double sign() const { return known_sign() != 0 ? known_sign() : force[0] < 0 ? -1 : 1; }
  int known_sign() const { return held_sign != 0 ? held_sign : sign_of_none; }
  double size() const { return has_sign ? sign() * force[0] : size_of_load(force); }
  // Against motion in this direction. of_mesh, of_bearing: per size.
  double friction(int direction, const std::array<double, 2>& of_mesh, double of_bearing) const {
    return is.friction_per_size(direction, sign(), of_mesh, of_bearing) * size();
  }
};

}  // namespace gelenk
