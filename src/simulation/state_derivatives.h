// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of a simulation, including closed loops, with respect to a choice of independent states.
#pragma once

#include <vector>

#include "simulation/sensitivity.h"
#include "simulation/simulation.h"

namespace gelenk {

// View of a simulation that outlives it. Requires initialize() or assemble(). Evaluation does not change the run, but
// allocates memory.
class StateDerivatives {
 public:
  explicit StateDerivatives(Simulation& of) : impl_(*of.impl_) {}

  // Indices into outputs() of joint coordinates and velocities that form a minimal set of independent states at the
  // start: size().degrees_of_freedom velocities, size().free_coordinates coordinates, and one more coordinate for each
  // quaternion whose three rotations are all independent.
  const IndependentOutputs& independent() const;

  // The states with respect to which derivatives are taken, as indices into outputs(): these coordinates, these
  // velocities, then all element states.
  const std::vector<int>& states() const;

  // Selects other coordinates and velocities, the same number as above. Throws UsageError for an output that is not a
  // tree coordinate or velocity.
  void take_states(const IndependentOutputs& chosen);

  // Allocates what all of the following use. Throws UsageError before initialize().
  void prepare();
  // Derivatives at the present state and inputs, in SI units. All throw NotDifferentiable if the states do not
  // determine the mechanism there. The Jacobians of all outputs and state derivatives with respect to states and
  // inputs.
  Linearization linearize(FrictionTreatment friction = FrictionTreatment::present);
  // Their derivative in the direction (dx, du), in the order of states() and inputs().
  DirectionalDerivative directional_derivative(const std::vector<double>& dx, const std::vector<double>& du);
  // First (column 0) and second (column 1) time derivatives of all outputs along the motion. udot, uddot: time
  // derivatives of the inputs; if empty, those set for the next step or, if none were set since the last step, those at
  // the end of the last step.
  Eigen::MatrixX2d output_derivatives(const std::vector<double>& udot = {}, const std::vector<double>& uddot = {});

 private:
  void refuse_closed_contacts(bool in_time);
  template <class Evaluate>
  auto differentiate(Evaluate evaluate);

  Simulation::Impl& impl_;
};

}  // namespace gelenk
