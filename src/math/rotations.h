// SPDX-License-Identifier: BSD-3-Clause
// Correction of rotation matrices and unit vectors that are given with rounding errors.
#pragma once

#include <Eigen/Core>

#include "math/spatial.h"

namespace gelenk {

// Returns the largest absolute entry of R^T R - 1; NaN if R contains one.
double rotation_error(const Eigen::Matrix3d& R);

// Returns the rotation nearest to R. If R is a rotation to within rounding error, it is returned bitwise unchanged, so
// that a scene that is written and read again remains the same.
Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R);
Pose3 orthonormalized(const Pose3& X);

// Returns x / |x| for a finite nonzero x; a unit vector is returned bitwise unchanged.
Eigen::VectorXd unit(const Eigen::VectorXd& x);

}  // namespace gelenk
