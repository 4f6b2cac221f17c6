// SPDX-License-Identifier: BSD-3-Clause
#include "math/spatial.h"

namespace gelenk {

Eigen::Matrix3d rotation_taking_z_to(const Eigen::Vector3d& n) {
  // For n = -z the shortest rotation is not unique: half a turn about x, exactly.
  if (n.z() <= -1.0) return Eigen::Vector3d(1, -1, -1).asDiagonal();
  // I + K + K^2/(1 + cos): exact for n = z, unlike a quaternion that has to be normalized.
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(n);
  const Eigen::Matrix3d K = cross_matrix<double>(axis);
  return Eigen::Matrix3d::Identity() + K + K * K / (1.0 + n.z());
}

}  // namespace gelenk
