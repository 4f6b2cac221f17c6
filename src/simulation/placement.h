// SPDX-License-Identifier: BSD-3-Clause
// The equations of a simulation at states that are given, not reached by steps.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

class Island;

// View of a simulation that outlives it and, except for start_from(), makes no steps: one after assemble(). Its outputs
// are then those at the states, the time and the inputs given.
class Placement {
 public:
  explicit Placement(Simulation& of) : simulation_(of), impl_(*of.impl_) {}

  // Moves to the states x (SI units, in the order of StateDerivatives::states()) at `time`. The dependent coordinates
  // follow on the branch of the present position: loops remain closed on a straight way there. Throws UsageError if the
  // way leads through a position where the states do not determine the others, or where the loops cannot be closed;
  // the simulation is then where it was.
  void move_to(std::span<const double> x, double time);
  // The same at the states, the time and the inputs of another simulation of the same scene with other numbers. Throws
  // UsageError also if it has other states.
  void follow(const Simulation& other, std::span<const double> x);
  // The same for a simulation after initialize(), which makes its next step from there in the modes of the other one.
  // Throws UsageError also where contacts between shapes have modes.
  void start_from(const Simulation& other, std::span<const double> x);

  // Where it is. The way to other states, and so their rounding errors, depend on where one begins.
  struct Position;
  std::shared_ptr<const Position> position() const;
  void return_to(const Position& at);

  // What has modes that change at events, for messages; empty: nothing.
  std::string modes() const;

  // Time derivatives of the states [SI units per s].
  std::vector<double> rates();

 private:
  void check_states(std::span<const double> x, double time) const;
  void approach(std::span<const double> x, double time, bool closed);
  void take_inputs_and_modes(const Simulation& other, std::span<const double> x, bool closed);
  Eigen::VectorXd remaining(std::span<const double> x) const;
  void keep_independent_rotations(std::size_t state, Eigen::VectorXd& change) const;
  void move(const Eigen::VectorXd& dx, double time);
  static void realize_in_present_modes(Island& of);
  bool has_loops() const;

  Simulation& simulation_;
  Simulation::Impl& impl_;
};

}  // namespace gelenk
