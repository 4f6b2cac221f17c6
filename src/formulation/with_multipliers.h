// SPDX-License-Identifier: BSD-3-Clause
// Common base of `index3` and `stabilized-index2`: the multipliers are unknowns in addition to q and v, and the
// integrator satisfies the constraints as equations in every step. As an ODE, for methods that require one, they are
// the index-1 form.
#pragma once

#include <string>
#include <string_view>

#include "formulation/formulation.h"

namespace gelenk {

class WithMultipliers : public Formulation {
 public:
  bool consistent(double t, double* x, double* xdot) final;
  std::string obstacle(const double* y) final;
  void serialize(Archive& archive) final;

 protected:
  WithMultipliers(std::string_view name, const FormulationContext& context);

  using Vector = Eigen::Map<Eigen::VectorXd>;
  using Matrix = Eigen::Map<Eigen::MatrixXd>;

  // r <- qdot - N v and M vdot + h + J^T lambda - tau. Leaves dynamics_ at x, including dynamics_.J(). Returns false if
  // x is not finite.
  bool equations_of_motion(double t, const double* x, const double* xdot, Vector& r);
  // Their Jacobian into F_x and M into F_xdot, the other entries zero; leaves jacobians_ at x. Returns false as above.
  bool motion_jacobian(double t, const double* x, const double* xdot, Matrix& F_x, Matrix& F_xdot);
  // Indices of the first and the second `rows` unknowns after y, or equations after those of motion.
  auto first() const { return Eigen::seqN(size(), mechanism_.rows); }
  auto second() const { return Eigen::seqN(size() + mechanism_.rows, mechanism_.rows); }
  // Whether constraint equation k holds positions, not only their rates.
  bool holds_position(int k) const { return position_rows_[k]; }

 private:
  bool assemble(double t, const double* x);

  std::string name_;
  std::vector<bool> position_rows_;
  RowMatrix M_;
  Eigen::VectorXd f_;            // tau - h
  double best_pivot_ratio_ = 0;  // largest pivot ratio of the constraint Jacobian at a start
};

}  // namespace gelenk
