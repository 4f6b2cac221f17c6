// SPDX-License-Identifier: BSD-3-Clause
// Forces whose direction is not defined where their ports are, as of a spring between two points that have come
// together.
#pragma once

#include <array>

#include "kinematics/model.h"
#include "kinematics/readings.h"

namespace gelenk {
namespace detail {

// Where a port is; for forces that ask for no more.
struct PortPlace {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& p() const { return at; }
};

}  // namespace detail

// Such a force of the scene; -1: there is none. at: after set_root_poses().
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
