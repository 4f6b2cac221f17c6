// SPDX-License-Identifier: BSD-3-Clause
// Forces of contacts that may be redundant, and the speed up to which sliding is slow.
#pragma once

#include <Eigen/Core>

#include "linear/least_norm.h"

namespace gelenk {

// Speeds far above those by which differences are taken, up to which directions are kept then [natural units].
inline constexpr double slow_sliding = 1e-4;

// A solution of G x = r, where G may be singular.
Eigen::VectorXd redundant_solution(const Eigen::MatrixXd& G, const Eigen::VectorXd& r);
// The solution of least norm, if G is singular; weights: of the entries of x in that norm.
Eigen::VectorXd least_norm_solution(LeastNormSolver& solver, const Eigen::MatrixXd& G, const Eigen::VectorXd& r,
                                    const Eigen::VectorXd& weights);

}  // namespace gelenk
