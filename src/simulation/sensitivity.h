// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of a simulation's outputs and state derivatives: by its states and inputs, and by time.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/constrained_sensitivity.h"
#include "outputs/outputs.h"
#include "scene/signals.h"
#include "simulation/island.h"
#include "simulation/states.h"

namespace gelenk {

// What differs along directions, one a column, of (states; inputs): first the outputs, then the states' derivatives.
// Units: those of the outputs, over those of states and inputs.
struct DirectionalDerivative {
  Eigen::MatrixXd outputs, rates;
  Eigen::VectorXd xdot;  // the states' derivatives themselves
};

// d xdot = A dx + B du, d y = C dx + D du, about a point at which xdot is as told; x: states, y: all outputs. Where a
// quaternion is among the states, the four numbers are moved as if they were normalized afterwards: along
// itself it cannot move, so that A has a zero eigenvalue for each.
struct Linearization {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd xdot;
};

// Keeps to what it is made of; asking changes nothing there.
class Sensitivity {
 public:
  using Islands = std::vector<std::unique_ptr<Island>>;
  // independent: by island. u: all inputs, read at each call.
  Sensitivity(const ReducedScene& reduced, const Islands& islands, const Outputs& readings,
              const std::vector<Signal>& outputs, const std::vector<StateVariable>& states,
              const std::vector<Independent>& independent, const std::vector<double>& u);

  // All three throw Undetermined and SingularMass, faulty_island() telling where.
  Linearization linearize();
  // One direction: dx (states), du (inputs).
  DirectionalDerivative along(const std::vector<double>& dx, const std::vector<double>& du);
  // Of all outputs along the motion: column 0 the first, column 1 the second time derivatives. udot, uddot: the
  // inputs'.
  Eigen::MatrixX2d in_time(const std::vector<double>& udot, const std::vector<double>& uddot);

  int faulty_island() const { return at_; }

 private:
  ConstrainedSensitivity& stand(int island);
  // Adds what island `i` does along these directions (states; inputs), where it stands.
  void add(int i, const Eigen::MatrixXd& directions, DirectionalDerivative& out);
  void add_rates(int i, const MovedState& moved, DirectionalDerivative& out) const;
  // Whether some output of the island is more than an entry of its state.
  bool reads(int i) const;
  template <class T, class Take>
  void read(int i, CarriedState<T>& at, Take take) const;
  std::vector<int> columns_of(int island) const;
  const JointPlace& place_of(const StateVariable& state) const;
  int component_of(const StateVariable& state) const;

  const ReducedScene& reduced_;
  const Islands& islands_;
  const Outputs& readings_;
  const std::vector<Signal>& signals_;
  const std::vector<StateVariable>& states_;
  const std::vector<double>& u_;
  std::vector<std::unique_ptr<ConstrainedSensitivity>> sensitivities_;
  int at_ = 0;
};

}  // namespace gelenk
