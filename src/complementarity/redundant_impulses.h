// SPDX-License-Identifier: BSD-3-Clause
// Cone problems in which other impulses have the same effect, as at the corners of a box, or along the normal and the
// tangent of a point that can move in one direction only: how they are shared decides on friction, must not depend on
// rounding, and may keep other methods from converging. Contacts that yield a little have unique impulses, nearly those
// of least norm; what they yield is removed by proximal iterations (Rockafellar 1976).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "complementarity/cone.h"

namespace gelenk {

// Keeps its memory: a problem no larger than those before allocates nothing.
class RedundantImpulses {
 public:
  // Whether there are any in a problem with a matrix.
  bool are_in(const ConeProblem& problem);
  // x <- the impulses of a problem in which there are any; an initial guess x only saves iterations. options: of each
  // iteration; most_iterations: of the solver, in all.
  ConeResult solve(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options, int most_iterations,
                   double* x);

 private:
  void set_weights(const ConeProblem& problem);

  std::vector<double> factors_, yielding_, weights_, before_, right_;
};

// A solver by another one, whose solution depends on the initial guess where impulses are redundant: of small problems,
// it is the one above.
class SolverOfRedundant final : public ConeSolver {
 public:
  explicit SolverOfRedundant(std::unique_ptr<ConeSolver> solver) : solver_(std::move(solver)) {}

  ConeResult solve(const ConeProblem& problem, const ConeOptions& options, double* x) override;

 private:
  std::unique_ptr<ConeSolver> solver_;
  RedundantImpulses redundant_;
  std::vector<double> start_, x_;
};

}  // namespace gelenk
