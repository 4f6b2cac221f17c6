// SPDX-License-Identifier: BSD-3-Clause
// What `penalty` and `augmented-lagrangian` share: constraints as a mass a, a damper and a spring in every row,
//   (M + a J^T J) vdot = tau - h + a J^T (gamma - 2 Omega mu J v - Omega^2 Phi)     (Bayo, Garcia de Jalon & Serna
//   1988).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "formulation/formulation.h"

namespace gelenk {

class Penalized : public Formulation {
 public:
  explicit Penalized(const FormulationContext& context);
  void start(const std::vector<double>& cut_q, double t, const double* y) override;

 protected:
  bool factorizes_constraints() const override { return false; }
  // M_, f_ and wish_ at the position of dynamics_ and the speeds v, and the factors of M + a J^T J. False: it has none.
  bool assemble(const double* v);
  // The penalised accelerations at y, their factors kept. False: M has none.
  bool accelerate(double t, const double* y, double* vdot) override;
  // From slopes of J vdot - gamma to those of J vdot - wish_.
  void stabilization_jacobian();

  double a_ = 0;
  Eigen::MatrixXd M_;
  Eigen::VectorXd f_, guess_;  // tau - h; what J vdot should be
  Eigen::VectorXd lambda_;
  Eigen::MatrixXd penalised_;  // M + a J^T J
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace gelenk
