// SPDX-License-Identifier: BSD-3-Clause
// Closed positions at rest or, in steady motion, with velocities, their accelerations and the derivatives of these, as
// searches for equilibria evaluate them. Friction acts on what moves, on what rests only after hold_friction(); of hard
// limits, those act that are in contact.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/equilibrium.h"

namespace gelenk {

// The unknowns x are the independent coordinates that determine the others best there (the acceleration of another one
// would vanish at its dead center, too, regardless of the other joints), in steady motion followed by the independent
// velocities; after them come the unknown inputs and the element states. All but q, v and u is in the mechanism's time
// scale.
struct TrialState {
  std::vector<double> q, cut_q, v, u;
  std::vector<int>
      contacts{};  // by lock (dynamics/switching_forces.h): 1 in contact at the upper, -1 at the lower bound, or 0
  std::vector<int> slips{};  // by lock, in steady motion: the direction in which what rests is about to slip, or 0
  // Set by evaluate():
  Eigen::VectorXd vdot{};                                       // of all velocities
  Eigen::VectorXd accelerations{};                              // those requested in steady motion
  Eigen::VectorXd rates{};                                      // of the element states
  Eigen::VectorXd hold_gaps{};                                  // by value held, what it lacks
  std::vector<std::array<SwitchingForces::Depth, 2>> depths{};  // by lock: beyond its upper and its lower bound
  // Set by differentiate():
  std::vector<int> speeds{};  // indices of the independent velocities
  // What has to vanish: their accelerations, or those requested, and the rates of the element states.
  Eigen::VectorXd a{};
  Eigen::MatrixXd A{}, B{};                 // Jacobians of a with respect to x and the unknown inputs
  Eigen::VectorXd sizes{};                  // magnitudes of the unknowns
  Eigen::MatrixXd displacement_jacobian{};  // displacements of all by the unknowns
  Eigen::MatrixXd velocity_change{};        // in steady motion, changes of all velocities by the unknowns
  Eigen::MatrixXd velocity_jacobian{};      // all velocities by independent velocities
  Eigen::MatrixXd coordinate_rates{};       // rates of the independent coordinates by independent velocities
  // One row for each value held, by the unknowns; and for each contact, and the change that puts it on the bound, and
  // what friction keeps at rest.
  Eigen::MatrixXd hold_rows{}, contact_rows{};
  Eigen::VectorXd contact_gaps{};

  const SwitchingForces::Depth& depth(int lock, int side) const {
    return depths[static_cast<std::size_t>(lock)][side > 0 ? 0 : 1];
  }
  // The derivatives of `a`, and of the values held, by displacements along the independent velocities and by element
  // states.
  Eigen::MatrixXd by_velocities() const;
  Eigen::MatrixXd held_by_velocities() const;
  bool is_balanced() const;   // nothing accelerates
  bool is_on_bounds() const;  // all contacts are at their bounds
};

class TrialStates {
 public:
  explicit TrialStates(const EquilibriumProblem& of);

  // Keeps coordinates with dry friction at rest from now on, by forces of any size.
  void hold_friction() { friction_holds_ = true; }
  int locks() { return forces().locks(); }
  Dynamics& dynamics() { return *dynamics_; }
  SwitchingForces& forces() { return dynamics_->switching_forces(); }

  // Sets what depends on q, cut_q, v, u and contacts; cut_q is unwrapped, v made consistent.
  void evaluate(TrialState& at);
  // Derivatives at the state that was evaluated last. Throws NotDifferentiablePoint and SingularMass.
  void differentiate(TrialState& at);
  // What has to vanish at `here`, at `there`.
  Eigen::VectorXd accelerations(const TrialState& here, const TrialState& there) const;
  // The closed state next to `here` displaced by z, with other velocities and inputs, evaluated; empty if closing
  // fails.
  std::optional<TrialState> closed_neighbor(const TrialState& here, const Eigen::VectorXd& z, const Eigen::VectorXd& dv,
                                            const Eigen::VectorXd& du);
  // Whether a limit may come into contact: not that of what a latch holds; where inputs are unknown, not that of what
  // is held.
  bool may_touch(int lock) const {
    return !borne_[static_cast<std::size_t>(lock)] && !dynamics_->switching_forces().hold_coordinate(lock);
  }
  // Brings every coordinate that is at a bound, or beyond it, into contact; returns whether there is a new one.
  bool touch(TrialState& at);
  // The coordinate of a lock by the unknowns.
  Eigen::RowVectorXd limit_row(const TrialState& at, int lock);
  // Whether friction, in steady motion, or a latch keeps the coordinate at rest.
  bool sticks(int lock, const TrialState& at);
  // Rotations of the joints by a displacement [rad].
  Eigen::VectorXd joint_rotations(const TrialState& here, const Eigen::VectorXd& z);

 private:
  void hold(const TrialState& at);
  void move_consistently(TrialState& at);
  void read(TrialState& at);
  void find_contact_rows(TrialState& at);
  void find_sizes(TrialState& at) const;
  bool rests(int lock, const TrialState& at);
  std::vector<MotionLaw::Derivatives> targets(const TrialState& at) const;
  void unwrap_angles(int cut, std::vector<double>& cut_q) const;

  const EquilibriumProblem& of_;
  const Mechanism& mechanism_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<EquilibriumRequest::UnknownInput> unknown_;  // those of the request, and the element states
  std::vector<int> sides_;                                 // held modes of all forces with modes
  std::vector<bool> borne_;                                // by lock
  bool friction_holds_ = false;
  double time_, time_squared_;  // s, s2
};

}  // namespace gelenk
