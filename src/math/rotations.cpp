// SPDX-License-Identifier: BSD-3-Clause
#include "math/rotations.h"

#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Rounding of R^T R for an R right to its last places: nine products, each off by about eps, with room.
constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();

}  // namespace

double rotation_error(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

Eigen::Matrix3d settled(const Eigen::Matrix3d& R) {
  Eigen::Matrix3d out = R;
  // Newton's iteration for the nearest rotation (Higham 1986): from 1e-6 two rounds reach rounding.
  for (int i = 0; i < 4 && rotation_error(out) > rounding; ++i) {
    out = (0.5 * out * (3.0 * Eigen::Matrix3d::Identity() - out.transpose() * out)).eval();
  }
  return out;
}

Pose3 settled(const Pose3& X) { return {settled(X.R), X.p}; }

Eigen::VectorXd unit(const Eigen::VectorXd& x) {
  if (std::abs(x.squaredNorm() - 1) <= rounding) return x;
  const Eigen::VectorXd scaled = x / x.cwiseAbs().maxCoeff();  // squares must not overflow or vanish
  return scaled / scaled.norm();
}

}  // namespace gelenk
