// SPDX-License-Identifier: BSD-3-Clause
// `stabilized-index2`: the constraints and their time derivatives, with a second set of multipliers
// (Gear, Gupta & Leimkuhler 1985),
//   qdot = N (v - J^T mu),   M vdot + h + J^T lambda = tau,   J v = b,   Phi = 0.
// mu is of the size of the step's error. J^T mu is used as in the source rather than M^-1 J^T mu: the metric of such a
// small correction does not affect the result, and M^-1 would have to be computed and differentiated in every
// iteration.
#include "formulation/with_multipliers.h"

namespace gelenk {
namespace {

class StabilizedIndex2 final : public WithMultipliers {
 public:
  explicit StabilizedIndex2(const FormulationContext& context)
      : WithMultipliers("stabilized-index2", context), JT_mu_(mechanism_.nv), rate_(mechanism_.nq) {}

  int multipliers() const override { return 2 * mechanism_.rows; }
  int index(int i) const override { return i < size() ? 1 : 2; }

  bool residual(double t, const double* x, const double* xdot, double* out) override {
    Vector r(out, unknowns());
    if (!equations_of_motion(t, x, xdot, r)) return false;
    if (mechanism_.rows == 0) return r.allFinite();
    JT_mu_.noalias() =
        dynamics_.J().transpose() * Eigen::Map<const Eigen::VectorXd>(x + size() + mechanism_.rows, mechanism_.rows);
    dynamics_.qdot_from_v(x, JT_mu_.data(), rate_.data());
    r.head(mechanism_.nq) += rate_;
    for (int k = 0; k < mechanism_.rows; ++k) {
      r[size() + k] = dynamics_.row_rates()[k];
      // A constraint without a position level has no mu either.
      r[size() + mechanism_.rows + k] = holds_position(k) ? dynamics_.Phi()[k] : x[size() + mechanism_.rows + k];
    }
    return r.allFinite();
  }

  // Exact for mu = 0; the derivatives of N J^T with respect to q, times a mu of the size of the step's error, are
  // omitted.
  bool residual_jacobians(double t, const double* x, const double* xdot, double* by_x, double* by_xdot) override {
    Matrix F_x(by_x, unknowns(), unknowns());
    Matrix F_xdot(by_xdot, unknowns(), unknowns());
    if (!motion_jacobian(t, x, xdot, F_x, F_xdot)) return false;
    if (mechanism_.rows == 0) return true;
    const auto q = Eigen::seqN(0, mechanism_.nq);
    F_x.block(0, size() + mechanism_.rows, mechanism_.nq, mechanism_.rows).noalias() =
        jacobians_.qdot_v * dynamics_.J().transpose();
    F_x(first(), q) = jacobians_.rate_q;
    F_x(first(), Eigen::seqN(mechanism_.nq, mechanism_.nv)) = dynamics_.J();
    F_x(second(), q) = jacobians_.Phi_q;
    for (int k = 0; k < mechanism_.rows; ++k) {
      if (!holds_position(k)) F_x(size() + mechanism_.rows + k, size() + mechanism_.rows + k) = 1;
    }
    return true;
  }

 private:
  Eigen::VectorXd JT_mu_, rate_;  // J^T mu; N J^T mu
};

}  // namespace

std::unique_ptr<Formulation> make_stabilized_index2(const FormulationContext& context) {
  return std::make_unique<StabilizedIndex2>(context);
}

}  // namespace gelenk
