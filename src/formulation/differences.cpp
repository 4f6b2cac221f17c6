// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/differences.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

bool differentiate(const std::function<bool(const double* y, double* fy)>& f, const double* y, const double* fy,
                   Eigen::Index first_row, Eigen::Ref<Eigen::MatrixXd> out, const DifferenceTaken& taken) {
  constexpr double relative_step = 1e-7;
  const Eigen::Index n = out.cols();
  Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXd>(y, n);
  Eigen::VectorXd here(n), there(n);
  bool is_finite = true;
  if (fy != nullptr)
    here = Eigen::Map<const Eigen::VectorXd>(fy, n);
  else
    is_finite = f(y, here.data());
  for (Eigen::Index k = 0; k < n && is_finite; ++k) {
    at[k] += relative_step * std::max(1.0, std::abs(y[k]));
    is_finite = f(at.data(), there.data());
    if (taken) taken(k, at[k] - y[k]);
    out.col(k) = (there - here).segment(first_row, out.rows()) / (at[k] - y[k]);
    at[k] = y[k];
  }
  return f(y, here.data()) && is_finite;
}

}  // namespace gelenk
