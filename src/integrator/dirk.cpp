// SPDX-License-Identifier: BSD-3-Clause
// L-stable diagonally implicit Runge-Kutta with adaptive steps (ARKODE's ARKStep), projected after each accepted step.
// For stiff scenes whose inputs jump often: there is no history to lose at a jump.
#include <arkode/arkode_arkstep.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>

#include "integrator/arkode_integrator.h"

namespace gelenk {
namespace {

// Newton's method starts from the state at the start of the step, which may be far away: with 3 iterations, ARKODE's
// default, it fails in every second step on the stiff flyball governor.
constexpr int dirk_newton_iterations = 10;
constexpr double dirk_safety = 0.8;  // with ARKODE's own 0.96 more steps are rejected
// Fraction of the tolerance used in the local error test (see ida.cpp). On the same scenes errors are 0.2 to 35 times
// the tolerance.
constexpr double dirk_fraction = 0.02;
constexpr double dirk_min_tolerance = 1e-13;
// Fraction of the tolerance of a step that Newton's method may leave in a stage. These errors add up over steps, unseen
// by the error test: a stiff torsion spring of 95 rad at 1e-10 has five times the error with ARKODE's default 0.1,
// which saves 6 % of the evaluations.
constexpr double dirk_newton_fraction = 0.01;
// Relative size of corrections that are rounding.
constexpr double newton_rounding = 100 * std::numeric_limits<double>::epsilon();
constexpr double divergence_ratio = 2.3;  // of a correction to the one before; ARKODE's own

class Dirk;

// Content of a vector that refers to its Dirk, as do its clones: ARKODE measures its error estimate by an operation of
// vectors.
struct OwnedContent {
  _N_VectorContent_Serial serial;
  Dirk* owner;
};

void set_owner(N_Vector v, Dirk* owner) {
  void* content = std::realloc(v->content, sizeof(OwnedContent));  // freed with the vector
  if (content == nullptr) throw std::bad_alloc();
  v->content = content;
  static_cast<OwnedContent*>(content)->owner = owner;
}

Dirk& owner(N_Vector v) { return *static_cast<OwnedContent*>(v->content)->owner; }

N_Vector clone(N_Vector v) {
  N_Vector w = sundials::made(N_VClone_Serial(v));
  set_owner(w, &owner(v));
  return w;
}

class Dirk final : public ArkodeIntegrator {
 public:
  Dirk(Equations& system, const IntegratorOptions& options)
      : ArkodeIntegrator(system, gelenk::slow_sliding(options.tolerance, false)),
        linear_(y_.get(), context_),
        newton_(sundials::made(SUNNonlinSol_Newton(y_.get(), context_))),
        damped_(sundials::new_vector(system, context_)),
        last_correction_(sundials::new_vector(system, context_)) {
    set_owner(y_.get(), this);
    y_->ops->nvclone = clone;
    y_->ops->nvwrmsnorm = [](N_Vector x, N_Vector weights) { return owner(x).norm(x, weights); };
    const double tolerance = std::max(dirk_min_tolerance, dirk_fraction * options.tolerance);
    adopt(ARKStepCreate(nullptr, sundials::rhs, 0, y_.get(), context_), tolerance);
    rounding_ = newton_rounding / tolerance;
    // Order 5: a pair of order 4 (ESDIRK436L2SA) takes 1.6 times the evaluations at 1e-8; with a fast undamped
    // oscillation, where the errors of all steps add up, errors are ten times as large in addition.
    ARKStepSetTableNum(memory_, ARKODE_ESDIRK547L2SA2_7_4_5, ARKODE_ERK_NONE);
    ARKodeSetSafetyFactor(memory_, dirk_safety);
    ARKodeSetNonlinearSolver(memory_, newton_.get());
    SUNNonlinSolSetConvTestFn(newton_.get(), converged, this);
    ARKodeSetMaxNonlinIters(memory_, dirk_newton_iterations);
    ARKodeSetMaxConvFails(memory_, max_error_test_failures);  // discontinuities affect Newton's method, too
    ARKodeSetNonlinConvCoef(memory_, std::max(dirk_newton_fraction, rounding_));
    ARKodeSetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
    ARKodeSetJacFn(memory_, sundials::jacobian);
    // By default a Jacobian is used for up to 51 steps, also if the factors are renewed: that takes up to 1.4
    // times the evaluations, in more iterations.
    ARKodeSetJacEvalFrequency(memory_, 1);
    // Takes the derivative of a stage from the equation that the stage solves. Evaluated again, it would multiply the
    // error left by Newton's method by the fastest rate (Hairer & Wanner 1996, sec. IV.8).
    ARKodeSetDeduceImplicitRhs(memory_, 1);
  }

  void inputs_touched() override {}  // its history continues
  // The Newton matrix is reused over many steps.
  bool will_have_history() const override { return true; }
  bool has_history() const override { return !fresh_; }

 private:
  // Hairer & Wanner 1996, (IV.8.10): with corrections d_m and their ratio r = d_m / d_(m-1), the remaining error is at
  // most r / (1 - r) d_m. The ratio is that of the present stage. ARKODE's own test uses one of an earlier stage, up to
  // 20 steps ago: if the factors were exact then, it accepts any first correction, even after step or Jacobian have
  // changed (an oscillator at 1e-9: an error of 1e-3 in one step, not visible in the error estimate).
  static int converged(SUNNonlinearSolver newton, N_Vector, N_Vector correction, sunrealtype tolerance,
                       N_Vector weights, void* self) {
    Dirk& dirk = *static_cast<Dirk*>(self);
    const double size = N_VWrmsNorm_Serial(correction, weights);
    int iteration = 0;
    SUNNonlinSolGetCurIter(newton, &iteration);
    const double remaining = iteration == 0 ? size : dirk.remaining_error(size, correction, weights);
    if (remaining <= tolerance || size <= dirk.rounding_) {
      dirk.estimate_due_ = true;
      return SUN_SUCCESS;
    }
    if (iteration > 0 && size > divergence_ratio * dirk.last_size_) return SUN_NLS_CONV_RECVR;
    dirk.last_size_ = size;
    N_VScale(1, correction, dirk.last_correction_.get());
    return SUN_NLS_CONTINUE;
  }

  // size: weighted norm of the correction. The ratio is that of the sizes, or that along the correction, if it is
  // larger: if the factors are too stiff in one direction, as those from a time at which a body slid more slowly,
  // corrections along it are small, and hardly any smaller the next time. After a first correction in other directions,
  // the second one would look as if Newton's method converged.
  double remaining_error(double size, N_Vector correction, N_Vector weights) const {
    const double* const d = N_VGetArrayPointer_Serial(correction);
    const double* const last = N_VGetArrayPointer_Serial(last_correction_.get());
    const double* const w = N_VGetArrayPointer_Serial(weights);
    const auto n = N_VGetLength_Serial(correction);
    double product = 0;
    for (sunindextype i = 0; i < n; ++i) product += w[i] * d[i] * w[i] * last[i];
    product = std::abs(product) / static_cast<double>(n);
    const double ratio = std::max(size / last_size_, size * size / product);
    return ratio < 1 ? ratio / (1 - ratio) * size : std::numeric_limits<double>::infinity();
  }

  // After the last stage ARKODE measures its error estimate, which is damped here first; other vectors are measured
  // unchanged. In a component that decays within the step the estimate is the difference of two interpolations, h^3 of
  // its motion; the actual error of the step is smaller by that decay, which (I - h a J)^-1, whose factors are
  // available, reproduces (Hosea & Shampine 1996; Hairer & Wanner 1996, sec. IV.8). Coordinates are damped twice, since
  // stiff springs act on them through their velocities, which show what is left of their estimates, divided by h.
  // Velocities and element states are not: what damping or a rate decays by itself would look smaller than its error.
  double norm(N_Vector x, N_Vector weights) {
    if (!estimate_due_) return N_VWrmsNorm_Serial(x, weights);
    estimate_due_ = false;
    N_VScale(1, x, damped_.get());
    const auto damp = [&] {
      return SUNLinSolSolve(linear_.solver.get(), linear_.matrix.get(), damped_.get(), damped_.get(), 0) == SUN_SUCCESS;
    };
    if (!damp()) return N_VWrmsNorm_Serial(x, weights);
    const double* const estimate = N_VGetArrayPointer_Serial(x);
    std::copy(estimate + system_.coordinates(), estimate + system_.size(),
              N_VGetArrayPointer_Serial(damped_.get()) + system_.coordinates());
    if (!damp()) return N_VWrmsNorm_Serial(x, weights);
    return N_VWrmsNorm_Serial(damped_.get(), weights);
  }

  void before_step() override { ARKodeSetLSetupFrequency(memory_, system_.jacobian_is_outdated() ? 1 : 0); }
  void reinitialize(void* memory) override {
    ARKStepReInit(memory, nullptr, sundials::rhs, t_, y_.get());
    estimate_due_ = false;  // of a step that was given up
  }

  sundials::DenseSolver linear_;
  sundials::NonlinearSolver newton_;
  sundials::Vector damped_;
  sundials::Vector last_correction_;
  double last_size_ = 0;  // its weighted norm
  double rounding_ = 0;   // weighted norm of corrections that are rounding
  bool estimate_due_ = false;
};

}  // namespace

std::unique_ptr<Integrator> make_dirk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Dirk>(system, options);
}

}  // namespace gelenk
