// SPDX-License-Identifier: BSD-3-Clause
// Detection of forces whose direction is undefined at the current position, such as that of a spring between two
// coincident points.
#pragma once

#include <array>

#include "kinematics/model.h"
#include "kinematics/readings.h"

namespace gelenk {
namespace detail {

// The position of a port, in the interface of element/force.h.
struct PortPlace {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& p() const { return at; }
};

}  // namespace detail

// Returns the index in the scene of such a force, or -1. at: after set_root_poses().
inline int undefined_force(const Loads& loads, const Readings<double>& at) {
  int found = -1;
  each_list(loads.forces, [&](const auto& list) {
    for (const auto& force : list) {
      std::array<detail::PortPlace, std::decay_t<decltype(force)>::ports> ports;
      for (std::size_t k = 0; k < ports.size(); ++k) {
        ports[k].at = at.link_pose(force.at[k].link).point(force.at[k].p);
      }
      if constexpr (requires { force.element.undefined(ports.data()); }) {
        if (found < 0 && force.element.undefined(ports.data())) found = force.force;
      }
    }
  });
  return found;
}

}  // namespace gelenk
