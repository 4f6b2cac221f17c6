// SPDX-License-Identifier: BSD-3-Clause
#include "math/rotations.h"

#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Rounding error of R^T R if R is accurate to the last digit: nine products, each with an error of about eps, and a
// margin.
constexpr double orthonormality_tolerance = 32 * std::numeric_limits<double>::epsilon();

}  // namespace

double rotation_error(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R) {
  Eigen::Matrix3d out = R;
  // Newton iteration for the nearest rotation (Higham 1986): from 1e-6 two iterations reach rounding error.
  for (int i = 0; i < 4 && rotation_error(out) > orthonormality_tolerance; ++i) {
    out = (0.5 * out * (3.0 * Eigen::Matrix3d::Identity() - out.transpose() * out)).eval();
  }
  return out;
}

Pose3 orthonormalized(const Pose3& X) { return {orthonormalized(X.R), X.p}; }

Eigen::VectorXd unit(const Eigen::VectorXd& x) {
  if (std::abs(x.squaredNorm() - 1) <= orthonormality_tolerance) return x;
  const Eigen::VectorXd scaled = x / x.cwiseAbs().maxCoeff();  // keeps the squares from overflow and underflow
  return scaled / scaled.norm();
}

}  // namespace gelenk
