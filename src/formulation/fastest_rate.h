// SPDX-License-Identifier: BSD-3-Clause
// The fastest rate of the equations, by which stability limits the steps of an explicit method.
#pragma once

#include <vector>

#include "formulation/equations.h"
#include "util/archive.h"

namespace gelenk {

// Step of an explicit method times the largest eigenvalue of df/dy: it is stable up to about 4, and seldom exceeds 1 if
// accuracy alone limits the step.
constexpr double stability_check_limit = 2.0;
constexpr double stability_limit = 4.0;

// The largest eigenvalue of df/dy by magnitude [1/s], by power iteration with finite differences of f.
class FastestRate {
 public:
  explicit FastestRate(Equations& system);
  // Returns the estimate at (t, y), at the cost of up to 9 evaluations; 0: unknown.
  double at(double t, const double* y);
  void serialize(Archive& archive) { archive.serialize(direction_); }

 private:
  Equations& system_;
  int n_;
  std::vector<double> direction_;  // the last one, a good initial guess for the next estimate
  std::vector<double> perturbed_, f_, f_perturbed_;
};

}  // namespace gelenk
