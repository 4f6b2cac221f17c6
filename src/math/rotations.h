// SPDX-License-Identifier: BSD-3-Clause
// Rotation matrices and directions that were given by numbers with rounding.
#pragma once

#include <Eigen/Core>

#include "math/spatial.h"

namespace gelenk {

// How far R^T R is from 1: largest entry of the difference.
double rotation_error(const Eigen::Matrix3d& R);

// R made a rotation to rounding. One that is so already keeps its bits: what was written reads back the same.
Eigen::Matrix3d settled(const Eigen::Matrix3d& R);
Pose3 settled(const Pose3& X);

// x / |x| for any finite x but zero; a unit vector keeps its bits.
Eigen::VectorXd unit(const Eigen::VectorXd& x);

}  // namespace gelenk
