// SPDX-License-Identifier: BSD-3-Clause
#include "math/spatial.h"

namespace gelenk {
namespace {

constexpr double rounding_of_unit_vector = 1e-15;

}  // namespace

Eigen::Matrix3d rotation_taking_z_to(const Eigen::Vector3d& n) {
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(n);
  const Eigen::Matrix3d K = cross_matrix<double>(axis);
  // I + K + K^2/(1 + cos): exact for n = z, unlike a quaternion that has to be normalized.
  if (n.z() >= 0) return Eigen::Matrix3d::Identity() + K + K * K / (1.0 + n.z());
  // Near n = -z, 1 + cos is only rounding errors; the axis is not. At n = -z, it is not unique either.
  const double sine = axis.norm();
  if (sine <= rounding_of_unit_vector) return Eigen::Vector3d(1, -1, -1).asDiagonal();
  return n.z() * Eigen::Matrix3d::Identity() + K + (1.0 - n.z()) * (axis / sine) * (axis / sine).transpose();
}

}  // namespace gelenk
