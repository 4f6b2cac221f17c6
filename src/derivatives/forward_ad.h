// SPDX-License-Identifier: BSD-3-Clause
// The Jacobians of the equations of motion by forward-mode automatic differentiation: the kernels run on dual numbers
// (math/dual.h), some directions at a time. It covers every mechanism; recursive.h is faster where it applies.
#pragma once

#include <memory>
#include <vector>

#include "derivatives/jacobians.h"
#include "derivatives/residual_evaluator.h"
#include "math/dual.h"

namespace gelenk {

// Computes the Jacobians at a point. Allocates at construction only.
class Differentiator {
 public:
  // inputs: number of the scene's inputs.
  Differentiator(const Mechanism& mechanism, const Loads& loads, int inputs);

  // See ResidualEvaluator.
  void hold(const int* sides) { residuals_->hold(sides); }
  // Overwrites `out`, according to its flags of_rows and of_inputs.
  void operator()(const LinearizationPoint& at, Jacobians& out);

 private:
  void run(const LinearizationPoint& at);
  template <class Store>
  void sweep(const LinearizationPoint& at, std::vector<Dual>& in, Store store);

  std::unique_ptr<ResidualEvaluator<Dual>> residuals_;
  std::vector<Dual> q_, v_, u_, vdot_, lambda_, targets_;
  std::vector<Dual> rates_;  // of the element states
};

}  // namespace gelenk
