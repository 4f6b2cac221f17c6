// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/scaled_solver.h"

#include <idas/idas.h>

#include <cmath>

#include "linear/pivots.h"

namespace gelenk::sundials {
namespace {

// Below this ratio of pivots the rows are dependent up to rounding.

ScaledSolver& of(SUNLinearSolver solver) { return *static_cast<ScaledSolver*>(solver->content); }

}  // namespace

ScaledSolver::ScaledSolver(const Equations& system, void* ida_memory, SUNContext context)
    : ida_memory_(ida_memory),
      matrix_(made(SUNDenseMatrix(system.unknowns(), system.unknowns(), context))),
      solver_(made(SUNLinSolNewEmpty(context))),
      row_scale_(system.unknowns()),
      column_scale_(system.unknowns()),
      rhs_(system.unknowns()),
      scaled_(system.unknowns(), system.unknowns()),
      lu_(system.unknowns()) {
  solver_->content = this;
  solver_->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
  solver_->ops->setup = setup;
  solver_->ops->solve = solve;
  solver_->ops->free = [](SUNLinearSolver s) -> SUNErrCode {
    s->content = nullptr;
    SUNLinSolFreeEmpty(s);
    return SUN_SUCCESS;
  };
  for (int i = 0; i < system.unknowns(); ++i) {
    row_power_.push_back(i < system.size() ? system.index(i) : 0);
    column_power_.push_back(system.index(i) - 1);
  }
}

void ScaledSolver::find_scales() {
  double cj = 1;
  IDAGetCurrentCj(ida_memory_, &cj);
  for (std::size_t i = 0; i < row_power_.size(); ++i) {
    row_scale_[i] = std::pow(cj, -row_power_[i]);
    column_scale_[i] = std::pow(cj, column_power_[i]);
  }
}

int ScaledSolver::setup(SUNLinearSolver solver, SUNMatrix A) {
  ScaledSolver& self = of(solver);
  const Eigen::Index n = self.row_scale_.size();
  const Eigen::Map<const Eigen::MatrixXd> J(SUNDenseMatrix_Data(A), n, n);
  self.find_scales();
  self.scaled_ = self.row_scale_.asDiagonal() * J * self.column_scale_.asDiagonal();
  self.lu_.compute(self.scaled_);
  return is_regular(self.lu_) ? 0 : 1;
}

// The scales belong to the present cj, not to that of the factors.
int ScaledSolver::solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
  ScaledSolver& self = of(solver);
  const Eigen::Index n = self.row_scale_.size();
  self.find_scales();
  const Eigen::Map<const Eigen::VectorXd> right(data(b), n);
  Eigen::Map<Eigen::VectorXd> out(data(x), n);
  self.rhs_ = self.row_scale_.cwiseProduct(right);
  out = self.lu_.solve(self.rhs_);
  out.array() *= self.column_scale_.array();
  return out.allFinite() ? 0 : 1;
}

}  // namespace gelenk::sundials
