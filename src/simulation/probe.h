// SPDX-License-Identifier: BSD-3-Clause
// What tests look at inside a simulation, and what measures it.
#pragma once

#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

class Island;

// Of a simulation that outlives it, from initialize() on.
class Probe {
 public:
  explicit Probe(Simulation& of) : impl_(*of.impl_) {}

  // Equations of island i as its integrator sees them, and the state (q, v) at which it stands. Calls of the former
  // leave outputs of this moment undefined.
  Equations& equations(int island);
  const std::vector<double>& state(int island) const;
  // Derivatives of that island's residuals (derivatives/forward_ad.h) at x = (q, v, vdot, lambda, what is not needed),
  // under the present inputs, by recursion or by dual numbers. UsageError where x is too short.
  Jacobians residual_jacobians(int island, const std::vector<double>& x, bool by_duals) const;
  // s: CPU time of one evaluation of all equations of motion at the present state. Measures for some tens of ms.
  double evaluation_cost();

 private:
  static double evaluation_cost(Island& of, double budget);

  Simulation::Impl& impl_;
};

}  // namespace gelenk
