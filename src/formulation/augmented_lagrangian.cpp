// SPDX-License-Identifier: BSD-3-Clause
// `augmented-lagrangian` (Bayo & Ledesma 1996): the equations of `penalty` with multipliers, iterated in every
// evaluation,
//   lambda <- lambda + a (J vdot - target),   (M + a J^T J) dvdot = f - M vdot - J^T (lambda + a (J vdot - target)),
// until vdot converges. It then satisfies J vdot = target for any a, so its derivatives are those of the index-1 form.
#include <cmath>

#include "formulation/penalty.h"

namespace gelenk {
namespace {

constexpr double convergence_tolerance = 1e-13;  // change of vdot relative to 1 + |vdot|
constexpr double stagnation_tolerance = 1e-8;    // the same, accepted if rounding ends the progress earlier
constexpr int multiplier_iterations = 50;        // each iteration gains some digits; near singular configurations, few

class AugmentedLagrangian final : public Penalized {
 public:
  explicit AugmentedLagrangian(const FormulationContext& context)
      : Penalized(context), increment_(mechanism_.rows), multiplier_(mechanism_.rows), vdot_change_(mechanism_.nv) {}

 private:
  bool accelerate(double t, const double* y, double* vdot) override {
    return Penalized::accelerate(t, y, vdot) && (mechanism_.rows == 0 || iterate(vdot));
  }

  bool iterate(double* vdot) {
    Eigen::Map<Eigen::VectorXd> x(vdot, mechanism_.nv);
    lambda_.setZero();
    double before = INFINITY;
    for (int i = 0; i < multiplier_iterations; ++i) {
      increment_ = -a_ * target_;
      increment_.noalias() += a_ * dynamics_.J() * x;
      lambda_ += increment_;
      multiplier_ = lambda_ + increment_;
      vdot_change_ = f_;
      vdot_change_.noalias() -= M_ * x;
      vdot_change_.noalias() -= dynamics_.J().transpose() * multiplier_;
      factor_.solveInPlace(vdot_change_);
      x += vdot_change_;
      const double size = vdot_change_.norm() / (1 + x.norm());
      if (size <= convergence_tolerance) return true;
      if (!(size <= 0.5 * before)) return size <= stagnation_tolerance;
      before = size;
    }
    return before <= stagnation_tolerance;
  }

  void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) override {
    dynamics_.factorize();
    dynamics_.differentiate(drives_.u().data(), drives_.count(), vdot, jacobians_, lambda_.data());
    stabilization_jacobian();
    acceleration_jacobian(out);
  }

  Eigen::VectorXd increment_, multiplier_, vdot_change_;
};

}  // namespace

std::unique_ptr<Formulation> make_augmented_lagrangian(const FormulationContext& context) {
  return std::make_unique<AugmentedLagrangian>(context);
}

}  // namespace gelenk
