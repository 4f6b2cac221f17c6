// SPDX-License-Identifier: BSD-3-Clause
// Closes loops at given independent coordinates and velocities (coordinate partitioning, Wehage & Haug 1982): Newton's
// method changes the dependent ones only, from a base, a closed state that is set now and then. The result depends on
// the base and on the independent coordinates, not on what was closed in between.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "formulation/constraint_projector.h"
#include "linear/dense_factor.h"
#include "util/archive.h"

namespace gelenk {

class DependentCoordinates final : public ConstraintProjector {
 public:
  // coordinates, speeds: the independent ones, as indices of velocities. There are more coordinates than speeds if
  // there are nonholonomic constraint equations, which do not restrict positions.
  DependentCoordinates(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<int>& coordinates,
                       const std::vector<int>& speeds);

  // Takes the closed state y = (q, v) as the base. The constraint equations that determine the dependent coordinates
  // are chosen there if those chosen before have become unsuitable.
  void set_base(const double* y);
  // Completes these displacements of the independent coordinates since the base, the time dt [s] before, by those of
  // the dependent ones, to second order in the direction in which the base moves. change: nv numbers.
  void follow(double dt, Eigen::Ref<Eigen::VectorXd> change);
  // q <- the base, displaced.
  void displace_base(const Eigen::VectorXd& change, double* q);
  // Closes y = (q, v) by its dependent coordinates and velocities. Returns false if that fails; see blocked().
  bool close(double* y);

  // After close() failed, or where set_base() found that the independent coordinates do not determine the others: the
  // velocity whose coordinate the loops determine instead; -1: unknown.
  int blocked() const { return blocked_; }
  // Where that is not known: finds the one that is nearest to that at the base.
  void find_blocked_at_base();
  // The choice of equations; set_base() must follow.
  void serialize(Archive& archive);

 private:
  // What determines the dependent coordinates, or the dependent velocities.
  struct Level {
    std::vector<bool> permitted;              // by constraint equation
    std::vector<int> independent, dependent;  // velocities
    std::vector<int> rows;                    // as many as there are dependent ones; empty: not chosen
    double ratio_when_chosen = 0;             // of the pivots
    std::vector<double> factors;              // of their columns of dependent velocities
    std::vector<int> pivots;

    int size() const { return static_cast<int>(dependent.size()); }
    DenseMatrix matrix() { return {factors.data(), size(), size()}; }
    // x <- the solution for the right-hand side x.
    void solve(double* x) { solve_general(matrix(), pivots.data(), {x, size()}); }
  };
  void read_jacobian();
  bool choose_rows(Level& level);
  bool keep_rows(Level& level);
  double factorize(Level& level);
  void find_blocked(const Level& level);
  void find_course(const double* y);
  void solve(Level& level, const double* residual, double* dv);
  void find_residual(const Level& level, const double* v);
  bool close_speeds(double* v);

  void refactor() override;
  double renewal_ratio() const override;
  double most_corrected() const override;
  void min_norm_displacement(const double* residual, double* dv) override { solve(levels_[0], residual, dv); }

  std::array<Level, 2> levels_;  // of positions; of velocities
  bool are_same_ = true;         // both levels have the same equations and dependent velocities
  bool is_determined_ = true;    // by the independent coordinates, at the base
  bool is_lost_ = false;         // not at the position of the last factors
  int blocked_ = -1;
  std::vector<double> base_;
  // At the base: dependent per independent displacement; the independent velocities, the accelerations of the dependent
  // coordinates along them, and their velocities without them.
  Eigen::MatrixXd tangent_;
  Eigen::VectorXd speeds_, accelerations_, drift_;
  Eigen::MatrixXd J_;                        // rows x nv
  Eigen::VectorXd x_, row_, residual_, dv_;  // workspace
};

}  // namespace gelenk
