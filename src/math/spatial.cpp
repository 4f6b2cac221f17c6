// SPDX-License-Identifier: BSD-3-Clause
#include "math/spatial.h"

namespace gelenk {

Eigen::Matrix3d rotation_taking_z_to(const Eigen::Vector3d& n) {
  // Half a turn about x, exactly, where the shortest turn has no unique axis.
  if (n.z() <= -1.0) return Eigen::Vector3d(1, -1, -1).asDiagonal();
  // I + K + K^2/(1 + cos): exact for n = z, unlike a quaternion that has to be normalised.
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(n);
  const Eigen::Matrix3d K = cross_matrix<double>(axis);
  return Eigen::Matrix3d::Identity() + K + K * K / (1.0 + n.z());
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond Q(R);
  if (Q.w() < 0) Q.coeffs() = -Q.coeffs();
  const double s = Q.vec().norm();
  // Series below: sin(x)/x is 1 to rounding, and 0/0 is kept out.
  if (s < 1e-9) return 2.0 * Q.vec();
  return 2.0 * std::atan2(s, Q.w()) / s * Q.vec();
}

}  // namespace gelenk
