// SPDX-License-Identifier: BSD-3-Clause
// `baumgarte`: the index-1 form with J vdot = gamma - 2 alpha J v - beta^2 Phi (Baumgarte 1972). Constraint errors
// decay as those of a damped oscillator, e'' + 2 alpha e' + beta^2 e = 0; the contribution of each step persists for
// about 1 / alpha, so they are bounded by the error of the steps, but not zero.
#include "formulation/formulation.h"

namespace gelenk {
namespace {

// Default gain times step, critically damped. Errors decay within some tens of communication steps; explicit methods,
// stable up to about 4 / alpha, may still take steps of several tens of communication steps.
constexpr double gain_per_step = 0.1;

class Baumgarte final : public Formulation {
 public:
  explicit Baumgarte(const FormulationContext& context)
      : Formulation(context),
        alpha_(context.options.baumgarte_alpha > 0 ? context.options.baumgarte_alpha
                                                   : gain_per_step / context.options.step),
        beta_(context.options.baumgarte_beta > 0 ? context.options.baumgarte_beta : alpha_),
        bias_(mechanism_.rows) {}

 private:
  bool accelerate(double, const double* y, double* vdot) override {
    dynamics_.factorize();
    dynamics_.set_velocity(y + mechanism_.nq);
    for (int r = 0; r < mechanism_.rows; ++r) {
      bias_[r] = -2 * alpha_ * dynamics_.row_rates()[r] - beta_ * beta_ * dynamics_.Phi()[r];
    }
    dynamics_.set_constraint_bias(bias_.data());
    dynamics_.solve(drives_.u().data(), vdot);
    dynamics_.set_constraint_bias(nullptr);
    return true;
  }

  void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) override {
    dynamics_.differentiate(drives_.u().data(), drives_.count(), vdot, jacobians_);
    jacobians_.c_q() += 2 * alpha_ * jacobians_.rate_q + beta_ * beta_ * jacobians_.Phi_q;
    jacobians_.c_v() += 2 * alpha_ * dynamics_.J();
    acceleration_jacobian(out);
  }

  double alpha_, beta_;  // 1/s
  std::vector<double> bias_;
};

}  // namespace

std::unique_ptr<Formulation> make_baumgarte(const FormulationContext& context) {
  return std::make_unique<Baumgarte>(context);
}

}  // namespace gelenk
