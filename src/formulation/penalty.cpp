// SPDX-License-Identifier: BSD-3-Clause
// `penalty`: constraint errors remain in proportion to the constraint forces, Phi = lambda / (a Omega^2).
#include "formulation/penalty.h"

namespace gelenk {
namespace {

// Bayo's usual values. The penalty is this multiple of the mass that a constraint equation acts on at the start (trace
// of M over that of J^T J): larger values reduce the errors, but M loses more digits in the sum; 1e7 leaves it half of
// them.
constexpr double penalty = 1e7;
constexpr double Omega = 10;  // 1/s: decay rate of the constraint errors
constexpr double mu = 1;      // critically damped

class Penalty final : public Penalized {
 public:
  using Penalized::Penalized;

 private:
  bool accelerate(double t, const double* y, double* vdot) override {
    if (!Penalized::accelerate(t, y, vdot)) return false;
    if (mechanism_.rows == 0) return true;
    lambda_ = -a_ * target_;
    lambda_.noalias() += a_ * dynamics_.J() * Eigen::Map<const Eigen::VectorXd>(vdot, mechanism_.nv);
    return true;
  }

  // With lambda = a (J vdot - target): (M + a J^T J) dvdot = -(dr + a J^T dc), dr at constant lambda.
  void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) override {
    dynamics_.differentiate(drives_.u().data(), drives_.count(), vdot, jacobians_, lambda_.data());
    stabilization_jacobian();
    auto rows = out.middleRows(mechanism_.nq, mechanism_.nv);
    auto by_q = rows.leftCols(mechanism_.nq);
    auto by_v = rows.middleCols(mechanism_.nq, mechanism_.nv);
    by_q = -jacobians_.r_q();
    by_v = -jacobians_.r_v();
    if (mechanism_.rows > 0) {
      by_q.noalias() -= a_ * dynamics_.J().transpose() * jacobians_.c_q();
      by_v.noalias() -= a_ * dynamics_.J().transpose() * jacobians_.c_v();
    }
    if (drives_.states() > 0)
      rows.rightCols(drives_.states()) = -jacobians_.r_u.middleCols(drives_.first_state(), drives_.states());
    factor_.solveInPlace(rows);
  }
};

}  // namespace

Penalized::Penalized(const FormulationContext& context)
    : Formulation(context),
      M_(mechanism_.nv, mechanism_.nv),
      f_(mechanism_.nv),
      target_(mechanism_.rows),
      lambda_(Eigen::VectorXd::Zero(mechanism_.rows)),
      penalized_mass_(mechanism_.nv, mechanism_.nv),
      factor_(mechanism_.nv) {}

void Penalized::start(const std::vector<double>& cut_q, double t, const double* y) {
  Formulation::start(cut_q, t, y);
  if (a_ > 0 || mechanism_.rows == 0) return;
  dynamics_.assemble(drives_.u().data(), M_.data(), f_.data());
  a_ = penalty * M_.trace() / dynamics_.J().squaredNorm();
}

bool Penalized::accelerate(double, const double* y, double* vdot) {
  if (!assemble(y + mechanism_.nq)) return false;
  Eigen::Map<Eigen::VectorXd> x(vdot, mechanism_.nv);
  x = f_;
  if (mechanism_.rows > 0) x.noalias() += a_ * dynamics_.J().transpose() * target_;
  factor_.solveInPlace(x);
  return true;
}

bool Penalized::assemble(const double* v) {
  dynamics_.set_velocity(v);
  dynamics_.assemble(drives_.u().data(), M_.data(), f_.data());
  if (mechanism_.rows == 0) {
    factor_.compute(M_);
    return factor_.info() == Eigen::Success;
  }
  for (int r = 0; r < mechanism_.rows; ++r) {
    target_[r] = dynamics_.gamma()[r] - 2 * Omega * mu * dynamics_.row_rates()[r] - Omega * Omega * dynamics_.Phi()[r];
  }
  penalized_mass_ = M_;
  penalized_mass_.noalias() += a_ * dynamics_.J().transpose() * dynamics_.J();
  factor_.compute(penalized_mass_);
  return factor_.info() == Eigen::Success;
}

void Penalized::stabilization_jacobian() {
  if (mechanism_.rows == 0) return;
  jacobians_.c_q() += 2 * Omega * mu * jacobians_.rate_q + Omega * Omega * jacobians_.Phi_q;
  jacobians_.c_v() += 2 * Omega * mu * dynamics_.J();
}

std::unique_ptr<Formulation> make_penalty(const FormulationContext& context) {
  return std::make_unique<Penalty>(context);
}

}  // namespace gelenk
