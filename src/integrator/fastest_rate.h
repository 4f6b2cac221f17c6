// SPDX-License-Identifier: BSD-3-Clause
// Whether stability binds an explicit method.
#pragma once

#include <vector>

#include "formulation/equations.h"
#include "util/archive.h"

namespace gelenk {

// An explicit method's step times the largest eigenvalue of df/dy: it is stable to about 4, and where it is accurate to
// its tolerance alone, is seldom beyond 1.
constexpr double suspicious_reach = 2.0;
constexpr double stable_reach = 4.0;

// The largest eigenvalue of df/dy by magnitude [1/s], by the power method on differences of f.
class FastestRate {
 public:
  explicit FastestRate(Equations& system);
  // Takes up to 9 evaluations. 0: not known.
  double at(double t, const double* y);
  void serialize(Archive& archive) { archive.serialize(direction_); }

 private:
  Equations& system_;
  int n_;
  std::vector<double> direction_;  // the one found last is a good one to begin with
  std::vector<double> beside_, f_, f_beside_;
};

}  // namespace gelenk
