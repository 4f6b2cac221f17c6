// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace gelenk {

// Of all points of a contact of the scene: what ContactReadings shows.
struct ContactSum {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // ContactReadings::force, mode
  int mode = 0;
};

}  // namespace gelenk
