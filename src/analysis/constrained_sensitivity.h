// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of the motion of a mechanism: with respect to its independent coordinates and velocities and the
// inputs, with the dependent ones following from the constraints; and with respect to time along the motion. No finite
// differences are used: the equations are evaluated with dual numbers and power series (Griewank & Walther 2008, ch. 3
// and 13), and the implicit unknowns are solved for order by order:
//   J_h z = ds,  dq = N z,   J dv + d(J v)/dq dq = db,   [M J^T; J 0] (dvdot, dlambda) = -(dr, dc),
// where J_h are the rows of J that hold positions, s and b the targets of the coordinate rows.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/dependent_unknowns.h"
#include "analysis/mobility.h"
#include "derivatives/residual_evaluator.h"
#include "dynamics/dynamics.h"
#include "element/constraints/motion_law.h"
#include "event_driven/held_contacts.h"
#include "kinematics/stages.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

// Thrown if derivatives do not exist or are infinite.
class NotDifferentiablePoint : public std::runtime_error {
 public:
  // rows: the constraint Jacobian has lost rank; partition: the independent velocities do not determine the others;
  // spring: the ends of a spring coincide; mode: the mode of friction or of a limit is about to change; contact: that
  // of a contact of shapes.
  enum class What { rows, partition, spring, mode, contact };
  explicit NotDifferentiablePoint(What what, int force = -1)
      : std::runtime_error("derivatives do not exist"), what_(what), force_(force) {}
  explicit NotDifferentiablePoint(const LawEdge& edge) : NotDifferentiablePoint(What::contact, edge.contact) {
    edge_ = edge.of;
  }
  What reason() const { return what_; }
  // Index of the spring among the forces of the scene, of the force among those with modes of its island, or of the
  // contact of the scene.
  int force() const { return force_; }
  LawEdge::Of edge() const { return edge_; }

 private:
  What what_;
  int force_;
  LawEdge::Of edge_ = LawEdge::Of::normal_force;
};

// Targets with two time derivatives each, in the layout of Dynamics::set_targets.
std::vector<double> with_two_derivatives(const std::vector<MotionLaw::Derivatives>& targets);

// Coordinate changes dq (nq x n) as displacements along the velocities, velocity times time (nv x n).
Eigen::MatrixXd displacements(const Mechanism& mechanism, const double* q, const Eigen::MatrixXd& dq);

// State, inputs and solution as numbers of type T, and the equations evaluated there.
template <class T>
struct CarriedState {
  std::vector<T> q, v, u, vdot, lambda, targets;
  // Of all forces with modes, if they are held, and their modes. The derivatives of forces that hold redundantly, and
  // of the multipliers then, are not a number: nothing determines them.
  std::vector<T> forces;
  const int* modes = nullptr;
  // Of contacts of the scene, on the bodies with the first surface, along the axes of the root frame; empty: none is
  // closed. The derivatives of redundant ones are not a number.
  std::vector<Vector3<T>> contact_forces;
  std::unique_ptr<ResidualEvaluator<T>> equations;
};

// Sensitivities of a state, by columns: (dq, dv, dvdot, those of element states) stacked; with quaternions also the
// change of qdot; and of the rates of the element states.
struct MovedState {
  Eigen::MatrixXd y, qdot, state_rates;
};

// Uses its own workspace, so it does not affect a run. Allocates.
class ConstrainedSensitivity {
 public:
  // mobility, independent: of this mechanism. inputs: number of signals (kinematics/loads.h) without coordinates.
  ConstrainedSensitivity(const Mechanism& mechanism, const Loads& loads, const MobilityAnalysis& mobility,
                         const Independent& independent, int inputs);

  // Sets the point of differentiation: q, v, these signals u, coordinates of cut joints with full turns counted, and
  // the target of each coordinate row with its time derivatives. Throws SingularMass, and NotDifferentiablePoint if the
  // constraint Jacobian has lost rank or the ends of a spring meet.
  void set_point(const double* q, const double* v, const double* u, const double* cut_q,
                 const std::vector<MotionLaw::Derivatives>& targets);

  // Holds the forces with modes in these (SwitchingForces::hold) from the next set_point() on; empty: in those of the
  // state. What they keep at rest remains at rest: the derivatives of its velocities are 0.
  // contacts: those that are closed, in their modes; other contacts do not act.
  void hold(std::vector<int> sides, const ContactHold& contacts = {});
  // The present point: (q, v, vdot) stacked, and qdot.
  Eigen::VectorXd point() const;
  Eigen::VectorXd qdot() const;
  const Eigen::VectorXd& state_rates() const { return rates_; }  // of the element states

  // Derivatives along up to dual_directions directions, the columns of dq (nq), dv (nv) and du (inputs). Only the
  // components of independent coordinates and velocities are used; of a quaternion only the part that rotates, as if it
  // were normalized afterwards. Throws NotDifferentiablePoint if these do not determine the others.
  CarriedState<Dual>& directional_derivative(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv,
                                             const Eigen::MatrixXd& du);
  // The same for the state alone, along any number of directions, from the Jacobians of the equations.
  MovedState state_derivative(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv, const Eigen::MatrixXd& du);

  // Element states have rates that name forces: `rates` gives all rates where the accelerations are known.
  void set_rates_of_forces(std::function<std::vector<Series>(CarriedState<Series>&)> rates) {
    rates_of_forces_ = std::move(rates);
  }
  // Time derivatives along the motion for inputs with these first and second derivatives.
  CarriedState<Series>& time_derivatives(const double* udot, const double* uddot);

 private:
  template <class T>
  void begin(CarriedState<T>& at);
  template <class T, class Target>
  void set_targets(CarriedState<T>& at, Target target);
  Eigen::MatrixXd given_velocities(const Eigen::MatrixXd& dv) const;
  Eigen::MatrixXd stopped(Eigen::MatrixXd dv) const;
  void differentiate_targets(const Eigen::MatrixXd& du);
  Eigen::MatrixXd changes_of_targets(int order, const Eigen::MatrixXd& du) const {
    return gelenk::changes_of_targets(mechanism_, loads_, u_.data(), order, du);
  }
  void expand_targets(const double* udot, const double* uddot);
  void update_partition();
  Eigen::MatrixXd complete_dq(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& du) const;
  void differentiate_velocity(const Eigen::MatrixXd& dv);
  void differentiate_acceleration(const Eigen::MatrixXd& null_multipliers);
  void evaluate_accelerations(const Eigen::MatrixXd& dvdot, const Eigen::MatrixXd& dlambda, const Eigen::MatrixXd& dx,
                              bool shows_redundant);
  double correct_accelerations(Eigen::MatrixXd& dvdot, Eigen::MatrixXd& dlambda, Eigen::MatrixXd& dholding,
                               Eigen::MatrixXd& dx, bool again);
  void find_contact_forces(const double* u);
  void find_multipliers();
  void expand_acceleration(int k);
  void find_rates(std::vector<Series>& rates);
  void solve(Eigen::VectorXd& r, const Eigen::VectorXd& c, Eigen::VectorXd& l, Eigen::VectorXd& holding) const;
  MovedState state_derivative_in_contact(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv,
                                         const Eigen::MatrixXd& du);
  bool touches() const { return contacts_ != nullptr && contacts_->any(); }
  template <class T>
  void set_forces(CarriedState<T>& at, const std::vector<T>& holding);
  void find_null_multipliers();

  const Mechanism& mechanism_;
  int rank_, position_rank_;
  double best_pivot_ratio_;
  const Loads& loads_;
  int inputs_;
  std::unique_ptr<Dynamics> dynamics_;
  std::unique_ptr<HeldContacts> contacts_;  // null: no shapes can touch
  std::vector<int> sides_;                  // held modes
  std::vector<double> holding_;             // forces, by lock
  std::vector<Series> holding_in_time_;
  Eigen::VectorXd q_, v_, u_, vdot_, lambda_, rates_;
  std::vector<double> cut_q_;
  Eigen::MatrixXd J_;
  Stages stages_;
  Computed partition_{Stage::position}, jacobians_known_{Stage::velocity};
  Jacobians jacobians_;
  DependentUnknowns of_positions_, of_speeds_;
  std::vector<MotionLaw::Derivatives> targets_;
  // For redundant constraints: the multipliers of minimum norm are lambda = J x. null_multipliers_: orthogonal
  // projector onto the null space of J^T; inverse_: pseudo-inverse of J.
  bool redundant_ = false;
  Eigen::MatrixXd null_multipliers_, inverse_;
  Eigen::VectorXd x_;
  std::vector<Series> x_in_time_;
  CarriedState<Dual> dual_state_;
  CarriedState<Series> series_state_;
  std::function<std::vector<Series>(CarriedState<Series>&)> rates_of_forces_;
};

}  // namespace gelenk
