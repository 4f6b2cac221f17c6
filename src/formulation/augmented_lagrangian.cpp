// SPDX-License-Identifier: BSD-3-Clause
// `augmented-lagrangian` (Bayo & Ledesma 1996): the penalty's equations with multipliers, iterated in every evaluation,
//   lambda <- lambda + a (J vdot - wish),   (M + a J^T J) dvdot = f - M vdot - J^T (lambda + a (J vdot - wish)),
// until vdot stands. It then fulfils J vdot = wish whatever a is, so its slopes are those of the index-1 form.
#include <cmath>

#include "formulation/penalty.h"

namespace gelenk {
namespace {

constexpr double stands = 1e-13;  // change of vdot against its size
constexpr double enough = 1e-8;   // where rounding ends the progress earlier
constexpr int most = 50;          // each gains some digits; near positions that lose rank, few

class AugmentedLagrangian final : public Penalized {
 public:
  explicit AugmentedLagrangian(const FormulationContext& context)
      : Penalized(context), more_(mechanism_.rows), sum_(mechanism_.rows), change_(mechanism_.nv) {}

 private:
  bool accelerate(double t, const double* y, double* vdot) override {
    return Penalized::accelerate(t, y, vdot) && (mechanism_.rows == 0 || iterate(vdot));
  }

  bool iterate(double* vdot) {
    Eigen::Map<Eigen::VectorXd> x(vdot, mechanism_.nv);
    lambda_.setZero();
    double before = INFINITY;
    for (int i = 0; i < most; ++i) {
      more_ = -a_ * guess_;
      more_.noalias() += a_ * dynamics_.J() * x;
      lambda_ += more_;
      sum_ = lambda_ + more_;
      change_ = f_;
      change_.noalias() -= M_ * x;
      change_.noalias() -= dynamics_.J().transpose() * sum_;
      factor_.solveInPlace(change_);
      x += change_;
      const double size = change_.norm() / (1 + x.norm());
      if (size <= stands) return true;
      if (!(size <= 0.5 * before)) return size <= enough;
      before = size;
    }
    return before <= enough;
  }

  void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) override {
    dynamics_.factorize();
    dynamics_.differentiate(drives_.u().data(), drives_.count(), vdot, jacobians_, lambda_.data());
    stabilization_jacobian();
    acceleration_jacobian(out);
  }

  Eigen::VectorXd more_, sum_, change_;
};

}  // namespace

std::unique_ptr<Formulation> make_augmented_lagrangian(const FormulationContext& context) {
  return std::make_unique<AugmentedLagrangian>(context);
}

}  // namespace gelenk
