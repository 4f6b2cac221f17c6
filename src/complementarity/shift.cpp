// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/shift.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

namespace {
constexpr double fraction_solved = 0.2;  // a closer solution of the convex problem would be in vain
}

void FrozenShift::renew() {
  std::fill_n(shift_, at_.size(), 0.0);
  if (at_.exact()) add_lift(at_.cones(), at_.u().data(), shift_);
}

// As ConeIteration's, with the constant shift.
double FrozenShift::convex_residual() {
  const Eigen::Index n = at_.size();
  const ConeVector x = at_.x();
  ConeVector work(work_, n);
  work = x - at_.u() - ConeVector(shift_, n);
  at_.project_all(work_, work_);
  double largest = 0;
  for (const Cone& cone : at_.cones()) {
    const double square = (x - work).segment(cone.first, cone.size()).squaredNorm();
    largest = std::max(largest, std::sqrt(square) / at_.scale(cone.first));
  }
  return largest;
}

bool FrozenShift::renew_if_solved() {
  if (!at_.exact() || convex_residual() > fraction_solved * at_.residual()) return false;
  renew();
  return true;
}

}  // namespace gelenk
