// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/equations.h"

#include <algorithm>

namespace gelenk {

bool Equations::residual(double t, const double* x, const double* xdot, double* r) {
  if (!rhs(t, x, r)) return false;
  for (int i = 0; i < size(); ++i) r[i] = xdot[i] - r[i];
  return true;
}

bool Equations::residual_jacobians(double t, const double* x, const double*, double* F_x, double* F_xdot) {
  if (!jacobian(t, x, F_x)) return false;
  const int n = size();
  for (int i = 0; i < n * n; ++i) F_x[i] = -F_x[i];
  std::fill_n(F_xdot, n * n, 0.0);
  for (int i = 0; i < n; ++i) F_xdot[i * n + i] = 1;
  return true;
}

}  // namespace gelenk
