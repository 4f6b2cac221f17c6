// SPDX-License-Identifier: BSD-3-Clause
// Limited forces of which several act on the same motion: the distribution that uses their limits the least.
#pragma once

#include <Eigen/Core>

namespace gelenk {

// Returns the solution x of W x = b with the smallest largest |x_i| / limit_i, in which all forces are below their
// limits as long as any distribution is. W: symmetric and positive semidefinite, b in its range; limits: positive. By
// Dinkelbach's method (1967): the forces at their limits times a fraction permit a motion, whose power gives the next
// fraction.
Eigen::VectorXd least_load(const Eigen::MatrixXd& W, const Eigen::VectorXd& b, const Eigen::VectorXd& limits);

}  // namespace gelenk
