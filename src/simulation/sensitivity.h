// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of a simulation's outputs and state derivatives with respect to states, inputs and time.
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
#include "simulation/contact_gaps.h"
#include "simulation/island.h"
#include "simulation/states.h"

namespace gelenk {

// Derivatives of the outputs and of the state derivatives in directions of (states; inputs), one column per direction.
// Units: those of the outputs over those of states and inputs.
struct DirectionalDerivative {
  Eigen::MatrixXd outputs, rates;
  Eigen::VectorXd xdot;  // values of the state derivatives
};

// d xdot = A dx + B du, dy = C dx + D du about a point with the state derivatives xdot; x: states, y: all outputs.
// locked: the coordinates among the states that friction or a limit keeps at rest, by their outputs.
// A quaternion among the states is normalized after each change. It cannot change along itself, so A has a zero
// eigenvalue for each quaternion.
struct Linearization {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd xdot;
  std::vector<int> locked;
};

// Differentiates the islands it is constructed with, at their present state, and does not change them.
class Sensitivity {
 public:
  using Islands = std::vector<std::unique_ptr<Island>>;
  // independent: by island. u: read at each call.
  Sensitivity(const ReducedScene& reduced, const Islands& islands, const Outputs& readings,
              const std::vector<Signal>& outputs, const std::vector<int>& states,
              const std::vector<Independent>& independent, const Inputs& u);

  // All three throw NotDifferentiablePoint and SingularMass; faulty_island() is then the island concerned.
  Linearization linearize(FrictionTreatment friction);
  // The derivative in one direction: dx (states), du (inputs).
  DirectionalDerivative along(const std::vector<double>& dx, const std::vector<double>& du);
  // First (column 0) and second (column 1) time derivatives of all outputs along the motion. udot, uddot: those of the
  // inputs.
  Eigen::MatrixX2d in_time(const std::vector<double>& udot, const std::vector<double>& uddot);

  // The change (dq, dv) of an island if its states change by dx (states) to first order; friction, limits and
  // contacts do not hold it. Throws as above.
  Eigen::VectorXd displacement(int island, const Eigen::VectorXd& dx);

  int faulty_island() const { return current_island_; }
  // The place of a state in the (q, v, element states) of its island, and the sign with which it appears there.
  struct Place {
    int island = 0;
    int component = 0;  // in q, v or the element states
    double sign = 1;
    enum class Of { coordinates, velocities, elements } of = Of::coordinates;
  };
  Place place(std::size_t state) const;

 private:
  ConstrainedSensitivity& set_point(int island);
  // Adds the derivatives of island `i` in these directions (states; inputs) at the point set.
  void add(int i, const Eigen::MatrixXd& directions, DirectionalDerivative& out);
  void add_rates(int i, const MovedState& moved, DirectionalDerivative& out) const;
  template <class T>
  class ReadIsland;
  void add_rates_of_forces(int i, const std::vector<Dual>& rates, Eigen::Index first, Eigen::Index width,
                           DirectionalDerivative& out) const;
  // Whether an output of the island is not simply an entry of its state.
  bool has_computed_outputs(int i) const;
  template <class T, class Take>
  void read(int i, const ReadIsland<T>& of, Take take) const;
  std::vector<int> columns_of(int island) const;
  // Directions (states; inputs) as changes of q, v and the signals of an island.
  struct Directions {
    Eigen::MatrixXd dq, dv, du;
  };
  Directions directions_of(int island, const Eigen::MatrixXd& directions) const;

  const ReducedScene& reduced_;
  const Islands& islands_;
  const Outputs& readings_;
  const std::vector<Signal>& signals_;
  const std::vector<int>& states_;  // outputs
  const Inputs& u_;
  std::vector<std::unique_ptr<ConstrainedSensitivity>> sensitivities_;
  int current_island_ = 0;
  FrictionTreatment friction_ = FrictionTreatment::present;
  bool holds_contacts_ = true;
  NearestPoints nearest_;  // of the island at which the point was set
};

}  // namespace gelenk
