// SPDX-License-Identifier: BSD-3-Clause
// Whether factors are good for anything, told without asking the heap (which Eigen's rcond() does).
#pragma once

#include <Eigen/LU>

namespace gelenk {

// Of LU factors: smallest pivot over the largest, by magnitude. Of a matrix with rows that repeat others: rounding.
inline double pivot_ratio(const Eigen::PartialPivLU<Eigen::MatrixXd>& lu) {
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  return pivots.size() == 0 ? 1 : pivots.minCoeff() / pivots.maxCoeff();
}

}  // namespace gelenk
