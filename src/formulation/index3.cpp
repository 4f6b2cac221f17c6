// SPDX-License-Identifier: BSD-3-Clause
// `index3`: the original equations,
//   qdot = N v,   M vdot + h + J^T lambda = tau,   Phi = 0,
// with J v = b for nonholonomic constraints.
// The loops are closed in every step. J v = b holds only as accurately as the method differentiates q (Hairer & Wanner
// II, sec. VII.1), so velocities have the error of q divided by the step, and multipliers that divided by its square.
#include "formulation/with_multipliers.h"

namespace gelenk {
namespace {

class Index3 final : public WithMultipliers {
 public:
  explicit Index3(const FormulationContext& context) : WithMultipliers("index3", context) {}

  int multipliers() const override { return mechanism_.rows; }
  int index(int i) const override {
    const bool is_state = i >= drives_.motion_size() && i < size();
    if (mechanism_.rows == 0 || i < mechanism_.nq || is_state) return 1;
    return i < size() || !holds_position(i - size()) ? 2 : 3;
  }

  bool residual(double t, const double* x, const double* xdot, double* out) override {
    Vector r(out, unknowns());
    if (!equations_of_motion(t, x, xdot, r)) return false;
    for (int k = 0; k < mechanism_.rows; ++k)
      r[size() + k] = (holds_position(k) ? dynamics_.Phi() : dynamics_.row_rates())[k];
    return r.allFinite();
  }

  bool residual_jacobians(double t, const double* x, const double* xdot, double* by_x, double* by_xdot) override {
    Matrix F_x(by_x, unknowns(), unknowns());
    Matrix F_xdot(by_xdot, unknowns(), unknowns());
    if (!motion_jacobian(t, x, xdot, F_x, F_xdot)) return false;
    F_x(first(), Eigen::seqN(0, mechanism_.nq)) = jacobians_.Phi_q;
    for (int k = 0; k < mechanism_.rows; ++k) {
      if (holds_position(k)) continue;
      F_x.block(size() + k, 0, 1, mechanism_.nq) = jacobians_.rate_q.row(k);
      F_x.block(size() + k, mechanism_.nq, 1, mechanism_.nv) = dynamics_.J().row(k);
    }
    return true;
  }
};

}  // namespace

std::unique_ptr<Formulation> make_index3(const FormulationContext& context) {
  return std::make_unique<Index3>(context);
}

}  // namespace gelenk
