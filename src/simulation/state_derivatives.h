// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of a simulation, loops included, and the states that they are taken by.
#pragma once

#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// Of a simulation that outlives it, from initialize() on. Asking changes no run, and allocates.
class StateDerivatives {
 public:
  explicit StateDerivatives(Simulation& of) : impl_(*of.impl_) {}

  // Indices into outputs(): of the joints' coordinates and speeds that make up a minimal, independent set of states at
  // the start: size().freedoms speeds, as many coordinates and one more for each row that holds no position, and for
  // each quaternion whose three turns are all independent.
  const IndependentOutputs& independent() const;

  // The states that derivatives are taken by: these coordinates, then these speeds.
  const std::vector<StateVariable>& states() const;

  // From now on derivatives are taken by these, as many as above. Throws UsageError for one that is none of the tree.
  void take_states(const IndependentOutputs& independent);

  // At the present state and inputs; all throw NotDifferentiable where the states do not determine the mechanism.
  // - of all outputs and of the states' derivatives, by states and inputs;
  Linearization linearize();
  // - along the direction dx (as states()), du (as inputs());
  DirectionalDerivative directional_derivative(const std::vector<double>& dx, const std::vector<double>& du);
  // - of all outputs by time, along the motion: column 0 the first, column 1 the second. udot, uddot: the inputs'
  //   time derivatives; empty: those set for the step to come, or, where nothing was set since the last step, those
  //   with which the inputs have arrived.
  Eigen::MatrixX2d output_derivatives(const std::vector<double>& udot = {}, const std::vector<double>& uddot = {});

 private:
  template <class Ask>
  auto differentiate(Ask ask);

  Simulation::Impl& impl_;
};

}  // namespace gelenk
