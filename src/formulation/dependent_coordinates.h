// SPDX-License-Identifier: BSD-3-Clause
// Closes loops at given independent coordinates and velocities (coordinate partitioning, Wehage & Haug 1982): Newton's
// method changes the dependent ones only, from a base, a closed state that is set now and then. The result depends on
// the base and on the independent coordinates, not on what was closed in between.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <vector>

#include "formulation/constraint_projector.h"

namespace gelenk {

class DependentCoordinates final : public ConstraintProjector {
 public:
  // coordinates, speeds: the independent ones, as indices of velocities. There are more coordinates than speeds if
  // there are nonholonomic constraint equations, which do not restrict positions.
  DependentCoordinates(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<int>& coordinates,
                       const std::vector<int>& speeds);

  // Takes the closed position q (nq) as the base: chooses the constraint equations that determine the dependent
  // coordinates there.
  void set_base(const double* q);
  // q0 <- the base, displaced along its tangent by these displacements of the independent coordinates. change: nv
  // numbers, of which those of dependent ones are overwritten.
  void displace_base(Eigen::Ref<Eigen::VectorXd> change, double* q);
  // Closes y = (q, v) by its dependent coordinates and velocities. Returns false if that fails; see blocked().
  bool close(double* y);

  // After close() failed, or where set_base() found that the independent coordinates do not determine the others: the
  // velocity whose coordinate the loops determine instead; -1: unknown.
  int blocked() const { return blocked_; }

 private:
  // What determines the dependent coordinates, or the dependent velocities.
  struct Level {
    std::vector<bool> permitted;              // by constraint equation
    std::vector<int> independent, dependent;  // velocities
    std::vector<int> rows;                    // as many as there are dependent ones
    Eigen::MatrixXd J_d;                      // their columns of dependent velocities, and its factors
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
  };
  void read_jacobian();
  bool choose_rows(Level& level);
  bool factorize(Level& level);
  void find_blocked(const Level& level);
  void solve(const Level& level, const double* residual, double* dv);
  bool close_speeds(double* v);

  void refactor() override;
  double renewal_ratio() const override;
  void min_norm_displacement(const double* residual, double* dv) override;

  std::array<Level, 2> levels_;  // of positions; of velocities
  bool are_same_ = true;         // both levels have the same equations and dependent velocities
  bool is_determined_ = true;    // by the independent coordinates, at the base
  bool is_lost_ = false;         // not at the position of the last factors
  int blocked_ = -1;
  std::vector<double> base_;
  Eigen::MatrixXd J_, tangent_;        // rows x nv; at the base: dependent per independent displacement
  Eigen::VectorXd x_, residual_, dv_;  // workspace
};

}  // namespace gelenk
