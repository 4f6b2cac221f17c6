// SPDX-License-Identifier: BSD-3-Clause
// Quality of LU factors, without the memory allocation of Eigen's rcond().
#pragma once

#include <Eigen/LU>

namespace gelenk {

// Ratio of smallest to largest pivot of LU factors, by magnitude; at rounding level for dependent rows.
inline double pivot_ratio(const Eigen::PartialPivLU<Eigen::MatrixXd>& lu) {
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  return pivots.size() == 0 ? 1 : pivots.minCoeff() / pivots.maxCoeff();
}

// Whether these factors solve to some digits.
inline bool is_regular(const Eigen::PartialPivLU<Eigen::MatrixXd>& lu) { return pivot_ratio(lu) > 1e-16; }

}  // namespace gelenk
