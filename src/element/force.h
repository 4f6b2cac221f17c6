// SPDX-License-Identifier: BSD-3-Clause
// What acts between bodies. With one port or two, a force offers
//
//   act(at, u)       calls at[i].push(f, n) or at[i].push_along(f, n); what it does to the second port it does, the
//   other
//                    way, to the first
//   energy(at)       J, stored in it; may be left out
//   slopes(at, u)    derivatives (PortJacobians) of what it does to its last port; may be left out: dual numbers serve
//   undefined(at)    whether its direction is not defined where its ports are; may be left out
//   is_local()       whether it asks neither where its ports are nor how they move; may be left out
//   is_idle()        whether with these numbers it does nothing; may be left out
//
// at[i] is where the i-th port is and how it moves, in the axes of one and the same frame that stands still:
//   p, v             position [m] and velocity [m/s]
//   w                angular velocity [rad/s]
//   turned(x)        x, given along the port's own axes, along these;  from_world(x): given along the world's
//   own(x)           x along the port's own axes
//   push(f, n)       force [N] and torque [N m], if any, on the body, given along these;  push_along: along the port's
//   own
// u: its own inputs. The number T: double, dual, series.
#pragma once

#include <concepts>

#include "element/element.h"

namespace gelenk {

// Of the force f and the torque n that an element applies at its last port, seen from its first one (or from the
// world): by that port's displacement p and turn a, and by their rates.
struct PortJacobians {
  Eigen::Matrix3d f_p = Eigen::Matrix3d::Zero(), f_a = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d n_p = Eigen::Matrix3d::Zero(), n_a = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d f_v = Eigen::Matrix3d::Zero(), f_w = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d n_v = Eigen::Matrix3d::Zero(), n_w = Eigen::Matrix3d::Zero();
  bool of_points = false;  // neither n nor a counts
  bool damped = true;      // rates count
};

template <class F>
concept ForceElement = requires {
  { F::kind } -> std::convertible_to<std::string_view>;
  { F::summary } -> std::convertible_to<std::string_view>;
  { F::fields() } -> std::convertible_to<std::span<const Field>>;
} && (std::size(F::ports) == 1 || std::size(F::ports) == 2);

}  // namespace gelenk
