// SPDX-License-Identifier: BSD-3-Clause
// Limited forces of which several act on the same motion: the distribution that uses their limits the least.
#pragma once

#include <Eigen/Core>

namespace gelenk {

// out <- the solution x of W x = b with the smallest largest fraction of a finite bound, lower <= 0 <= upper, in which
// all forces are within their bounds as long as any distribution is; infinite bounds may be used freely. Of these
// solutions, that with the smallest second largest fraction, and so on, so that one part of a mechanism does not depend
// on how much another part is loaded. W: symmetric and positive semidefinite, b in its range. By Dinkelbach's method
// (1967): the forces at their bounds times a fraction permit a motion, whose power gives the next fraction.
void least_load(const Eigen::MatrixXd& W, const Eigen::VectorXd& b, const Eigen::VectorXd& lower,
                const Eigen::VectorXd& upper, Eigen::VectorXd& out);

}  // namespace gelenk
