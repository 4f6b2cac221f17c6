// SPDX-License-Identifier: BSD-3-Clause
// The linear equations of Newton's method for a DAE in IDA, scaled by the step so that their condition number remains
// bounded as the step decreases (Petzold & Lotstedt 1986; Bottasso, Bauchau & Cardona 2007): with cj the coefficient of
// xdot, an unknown i of index p is replaced by cj^(p-1) times another, and row i, if it determines xdot[i], is divided
// by cj^p. The result hardly depends on cj, so factors remain nearly exact while the step changes.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "formulation/equations.h"
#include "integrator/sundials.h"

namespace gelenk::sundials {

class ScaledSolver {
 public:
  // ida_memory: provides cj; must outlive this.
  ScaledSolver(const Equations& system, void* ida_memory, SUNContext context);
  ScaledSolver(const ScaledSolver&) = delete;
  ScaledSolver& operator=(const ScaledSolver&) = delete;

  SUNMatrix matrix() const { return matrix_.get(); }
  SUNLinearSolver solver() const { return solver_.get(); }

 private:
  static int setup(SUNLinearSolver solver, SUNMatrix A);
  static int solve(SUNLinearSolver solver, SUNMatrix A, N_Vector x, N_Vector b, sunrealtype tolerance);
  void find_scales();

  void* ida_memory_;
  Matrix matrix_;
  LinearSolver solver_;
  std::vector<int> row_power_, column_power_;
  Eigen::VectorXd row_scale_, column_scale_, rhs_;
  Eigen::MatrixXd scaled_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace gelenk::sundials
