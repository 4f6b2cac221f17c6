// SPDX-License-Identifier: BSD-3-Clause
// Closed positions at zero velocity, their accelerations and the derivatives of these, as searches for equilibria
// evaluate them. Friction is without effect unless hold_friction() is called; of hard limits, those act that are in
// contact.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/equilibrium.h"

namespace gelenk {

// Its independent coordinates are those that determine the others best there: the acceleration of another one would
// vanish at its dead center, too, regardless of the other joints.
struct RestPose {
  std::vector<double> q, cut_q;
  std::vector<int>
      contacts{};  // by lock (dynamics/branching.h): 1 in contact at the upper, -1 at the lower bound, or 0
  // Set by evaluate():
  Eigen::VectorXd vdot{};  // of all velocities, in the mechanism's time scale, as are the members below
  std::vector<std::array<Branching::Depth, 2>> depths{};  // by lock: beyond its upper and its lower bound
  // Set by differentiate():
  std::vector<int> speeds{};                // indices of the independent velocities
  Eigen::VectorXd a{};                      // their accelerations
  Eigen::MatrixXd A{};                      // Jacobian of a with respect to the independent coordinates
  Eigen::MatrixXd displacement_jacobian{};  // displacements of all by independent coordinates
  Eigen::MatrixXd velocity_jacobian{};      // all velocities by independent velocities
  Eigen::MatrixXd coordinate_rates{};       // rates of the independent coordinates by independent velocities
  // One row for each contact: its coordinate by the independent coordinates, and the change that puts it on the bound.
  Eigen::MatrixXd contact_rows{};
  Eigen::VectorXd contact_gaps{};

  const Branching::Depth& depth(int lock, int side) const {
    return depths[static_cast<std::size_t>(lock)][side > 0 ? 0 : 1];
  }
  bool is_balanced() const;   // nothing accelerates
  bool is_on_bounds() const;  // all contacts are at their bounds
};

class RestPoses {
 public:
  explicit RestPoses(const EquilibriumProblem& of);

  // Keeps coordinates with dry friction at rest from now on, by forces of any size.
  void hold_friction() { friction_holds_ = true; }
  int locks() { return forces().locks(); }
  Branching& forces() { return dynamics_->branching(); }

  // Sets what depends on q, cut_q and contacts; cut_q is unwrapped.
  void evaluate(RestPose& at);
  // Derivatives at the pose that was evaluated last. Throws NotDifferentiablePoint and SingularMass.
  void differentiate(RestPose& at);
  // The closed position next to `here` displaced by z, evaluated; empty if closing fails.
  std::optional<RestPose> closed_neighbor(const RestPose& here, const Eigen::VectorXd& z);
  // Brings every coordinate that is at a bound, or beyond it, into contact; returns whether there is a new one.
  bool touch(RestPose& at);
  // Rotations of the joints by a displacement [rad].
  Eigen::VectorXd joint_rotations(const RestPose& here, const Eigen::VectorXd& z);

 private:
  void hold(const RestPose& at);
  void unwrap_angles(int cut, std::vector<double>& cut_q) const;

  const EquilibriumProblem& of_;
  const Mechanism& mechanism_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<double> zero_velocity_;
  std::vector<int> sides_;  // held modes of all forces with modes
  bool friction_holds_ = false;
  double time_scale_squared_;  // s2
};

}  // namespace gelenk
