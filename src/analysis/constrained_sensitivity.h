// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of what a mechanism does: by its independent coordinates and speeds and by the inputs, what loops
// determine following, and by time along the motion. No difference quotients: the equations run on numbers that carry
// derivatives (Griewank & Walther 2008, ch. 3 and 13), and what they hold implicitly is solved for order by order:
//   J_h z = ds,  dq = N z,   J dv + d(J v)/dq dq = db,   [M J^T; J 0] (dvdot, dlambda) = -(dr, dc),
// J_h being the rows that hold positions, s and b what the coordinate rows are to be.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <memory>
#include <stdexcept>
#include <vector>

#include "analysis/mobility.h"
#include "derivatives/residual_evaluator.h"
#include "dynamics/dynamics.h"
#include "kinematics/stages.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

// The derivatives do not exist or are infinite.
class NotDifferentiablePoint : public std::runtime_error {
 public:
  // The rows have lost rank; the independent speeds leave others open; the ends of a spring meet.
  enum class What { rows, partition, spring };
  explicit NotDifferentiablePoint(What what, int force = -1)
      : std::runtime_error("derivatives do not exist"), what_(what), force_(force) {}
  What reason() const { return what_; }
  int force() const { return force_; }  // of the scene: the spring

 private:
  What what_;
  int force_;
};

// As Dynamics::set_targets takes them.
std::vector<double> with_two_derivatives(const std::vector<MotionLaw::Derivatives>& targets);

// Changes of coordinates, the columns of dq, as displacements along the speeds (speeds times time).
Eigen::MatrixXd displacements(const Mechanism& mechanism, const double* q, const Eigen::MatrixXd& dq);

// State, inputs and solution as numbers T, and the equations that stand there.
template <class T>
struct CarriedState {
  std::vector<T> q, v, u, vdot, lambda, targets;
  std::unique_ptr<ResidualEvaluator<T>> equations;
};

// How a state moves, by columns: (dq, dv, dvdot) one below the other; where q has quaternions, also the change of qdot.
struct MovedState {
  Eigen::MatrixXd y, qdot;
};

// Works in memory of its own, so asking it changes no run. Allocates.
class ConstrainedSensitivity {
 public:
  // structure, independent: of the mechanism. inputs: the scene's.
  ConstrainedSensitivity(const Mechanism& mechanism, const Loads& loads, const MobilityAnalysis& mobility,
                         const Independent& independent, int inputs);

  // Where to differentiate: q, v, all inputs u, coordinates of cut joints with their turns counted; of each coordinate
  // row what it is to be, with its derivatives in time.
  // Throws SingularMass, and Undetermined where the rows have lost rank.
  void set_point(const double* q, const double* v, const double* u, const double* cut_q,
                 const std::vector<MotionLaw::Derivatives>& targets);

  // Where it stands: (q, v, vdot) one below the other, and qdot.
  Eigen::VectorXd point() const;
  Eigen::VectorXd qdot() const;

  // Moves along up to dual_directions directions, the columns: dq (nq), dv (nv), du (inputs). Of dq only what belongs
  // to independent coordinates counts, of dv to independent speeds; of a quaternion only what turns, as if it were
  // normalized afterwards. Throws Undetermined where these do not determine the others.
  CarriedState<Dual>& directional_derivative(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv,
                                             const Eigen::MatrixXd& du);
  // The same of the state alone, along any number of directions: from the matrices of the equations' derivatives.
  MovedState state_derivative(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv, const Eigen::MatrixXd& du);

  // Follows the motion in time, under inputs with these first and second derivatives.
  CarriedState<Series>& time_derivatives(const double* udot, const double* uddot);

 private:
  template <class T>
  void begin(CarriedState<T>& at);
  // Of the unknowns `dependent`, those that take residuals of the rows away.
  struct Partition {
    std::vector<int> dependent;  // speeds
    std::vector<int> rows;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor;

    void compute(const Eigen::MatrixXd& J, int rank);
    Eigen::MatrixXd solve(const Eigen::MatrixXd& residuals, Eigen::Index nv) const;
  };
  template <class T, class Target>
  void set_targets(CarriedState<T>& at, Target target);
  void move_targets(const Eigen::MatrixXd& du);
  void follow_targets(const double* udot, const double* uddot);
  void know_partition();
  Eigen::MatrixXd whole_dq(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& du) const;
  void move_velocity(const Eigen::MatrixXd& dv);
  void move_acceleration(const Eigen::MatrixXd& null_multipliers);
  void follow_acceleration(int k);
  void solve(Eigen::VectorXd& r, const Eigen::VectorXd& c, Eigen::VectorXd& l) const;
  void find_null_multipliers();

  const Mechanism& mechanism_;
  int rank_, position_rank_;
  double best_pivot_ratio_;
  const Loads& loads_;
  int inputs_;
  std::unique_ptr<Dynamics> dynamics_;
  Eigen::VectorXd q_, v_, u_, vdot_, lambda_;
  std::vector<double> cut_q_;
  Eigen::MatrixXd J_;
  Stages stages_;
  Computed partition_{Stage::position}, jacobians_known_{Stage::velocity};
  Jacobians jacobians_;
  Partition of_positions_, of_speeds_;
  std::vector<MotionLaw::Derivatives> targets_;
  // Where rows repeat others: the multipliers of minimum norm are lambda = J x. idle_: what they leave out, an
  // orthogonal projector; inverse_: pseudo-inverse of J.
  bool redundant_ = false;
  Eigen::MatrixXd null_multipliers_, inverse_;
  Eigen::VectorXd x_;
  std::vector<Series> x_in_time_;
  CarriedState<Dual> moved_;
  CarriedState<Series> path_;
};

}  // namespace gelenk
