// SPDX-License-Identifier: BSD-3-Clause
// Access to the interior of a simulation, for tests and measurements.
#pragma once

#include <vector>

#include "derivatives/jacobians.h"
#include "formulation/equations.h"
#include "simulation/simulation.h"
#include "time_stepping/recorded_problem.h"

namespace gelenk {

class Island;

// View of a simulation that outlives it. Requires initialize().
class Probe {
 public:
  explicit Probe(Simulation& of) : simulation_(of), impl_(*of.impl_) {}

  // The equations of an island as its integrator evaluates them, and its state (q, v). Evaluating the equations
  // invalidates the outputs at the present time.
  Equations& equations(int island);
  const std::vector<double>& state(int island) const;
  // Jacobians of the island's residuals (derivatives/forward_ad.h) at x = (q, v, vdot, lambda, ...), with the present
  // inputs, by recursion or by dual numbers. Throws UsageError if x is too short.
  Jacobians residual_jacobians(int island, const std::vector<double>& x, bool by_duals) const;
  // CPU time of one evaluation of the equations of motion of all islands at the present state [s]. Measures for some
  // tens of ms.
  double evaluation_cost();
  // Advances to `end` and returns the cone problems of all islands that were solved on the way.
  std::vector<RecordedProblem> record_cone_problems(double end);

 private:
  static double evaluation_cost(Island& of, double budget);

  Simulation& simulation_;
  Simulation::Impl& impl_;
};

}  // namespace gelenk
