// SPDX-License-Identifier: BSD-3-Clause
// Common base of `penalty` and `augmented-lagrangian`: a mass a, a damper and a spring in every constraint equation,
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
  // Computes M_, f_ and target_ at the position of dynamics_ with velocities v, and the factors of M + a J^T J. Returns
  // false if it is not positive definite.
  bool assemble(const double* v);
  // The penalized accelerations at y; keeps the factors. Returns false if the matrix is not positive definite.
  bool accelerate(double t, const double* y, double* vdot) override;
  bool leaves_solution() const override { return false; }
  // Converts jacobians_.c from derivatives of J vdot - gamma to those of J vdot - target_.
  void stabilization_jacobian();

  double a_ = 0;
  Eigen::MatrixXd M_;
  Eigen::VectorXd f_, target_;  // tau - h; target of J vdot
  Eigen::VectorXd lambda_;
  Eigen::MatrixXd penalized_mass_;  // M + a J^T J
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace gelenk
