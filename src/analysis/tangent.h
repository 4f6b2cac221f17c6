// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of what a mechanism does: by its independent coordinates and speeds and by the inputs, what loops
// determine following, and by time along the motion. No difference quotients: the equations run on numbers that carry
// derivatives (Griewank & Walther 2008, ch. 3 and 13), and what they hold implicitly is solved for order by order:
//   J z = 0,  dq = N z,   J dv + d(J v)/dq dq = 0,   [M J^T; J 0] (dvdot, dlambda) = -(dr, dc).
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <memory>
#include <stdexcept>
#include <vector>

#include "dynamics/dynamics.h"
#include "dynamics/extended.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

// The derivatives do not exist or are infinite.
class Undetermined : public std::runtime_error {
 public:
  enum class What { rows, partition };  // the rows have lost rank; the independent speeds leave others open
  explicit Undetermined(What what)
      : std::runtime_error(what == What::rows ? "singular position" : "dependent speeds not determined"), what_(what) {}
  What reason() const { return what_; }

 private:
  What what_;
};

// State, inputs and solution as numbers T, and the equations that stand there.
template <class T>
struct Carried {
  std::vector<T> q, v, u, vdot, lambda;
  std::unique_ptr<Extended<T>> equations;
};

// Works in memory of its own, so asking it changes no run. Allocates.
class Tangent {
 public:
  // rank: of the rows, at positions without special symmetry. independent: nv - rank speeds. inputs: the scene's.
  Tangent(const Mechanism& mechanism, const Loads& loads, int rank, const std::vector<int>& independent, int inputs);

  // Where to differentiate: q, v, all inputs u, coordinates of cut joints with their turns counted.
  // Throws SingularMass, and Undetermined where the rows have lost rank.
  void stand(const double* q, const double* v, const double* u, const double* cut_q);

  // Moves along up to dual_directions directions, the columns: dq (nq), dv (nv), du (inputs). Of dq and dv only what
  // belongs to independent speeds counts; of a quaternion only what turns, as if it were normalised afterwards.
  // Throws Undetermined where these do not determine the others.
  Carried<Dual>& move(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dv, const Eigen::MatrixXd& du);

  // Follows the motion in time, under inputs with these first and second derivatives.
  Carried<Series>& follow(const double* udot, const double* uddot);

 private:
  template <class T>
  void begin(Carried<T>& at);
  Eigen::MatrixXd displacements(const Eigen::MatrixXd& dq) const;
  Eigen::MatrixXd dependent_part(const Eigen::MatrixXd& rates) const;
  void move_velocity(const Eigen::MatrixXd& dv);
  void move_acceleration(const Eigen::MatrixXd& idle);
  void follow_acceleration(int k);
  void solve(Eigen::VectorXd& r, const Eigen::VectorXd& c, Eigen::VectorXd& l) const;
  void find_idle();

  const Mechanism& mechanism_;
  int rank_, inputs_;
  std::vector<int> independent_, dependent_;
  std::unique_ptr<Dynamics> dynamics_;
  Eigen::VectorXd q_, v_, u_, vdot_, lambda_;
  std::vector<double> cut_q_;
  Eigen::MatrixXd J_;
  bool partition_known_ = false;  // partition_ is of J_
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> partition_;
  // Where rows repeat others: the multipliers of minimum norm are lambda = J x. idle_: what they leave out, an
  // orthogonal projector; inverse_: pseudo-inverse of J.
  bool redundant_ = false;
  Eigen::MatrixXd idle_, inverse_;
  Eigen::VectorXd x_;
  std::vector<Series> x_in_time_;
  Carried<Dual> moved_;
  Carried<Series> path_;
};

}  // namespace gelenk
