// SPDX-License-Identifier: BSD-3-Clause
// L-stable diagonally implicit Runge-Kutta with adaptive steps (ARKODE's ARKStep), projected after each accepted
// step. For stiff scenes whose inputs jump often: nothing is lost at a jump, where a multistep method's history is.
#include <arkode/arkode_arkstep.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>

#include "integrator/arkode_integrator.h"

namespace gelenk {
namespace {

// Newton's method starts at the step's start and may have far to go: with 3 iterations, ARKODE's own limit, it fails
// every second step on the stiff flyball governor.
constexpr int most_iterations = 10;
constexpr double safety = 0.8;  // with ARKODE's own 0.96 more steps are rejected
// The local error test's share of the tolerance (see ida.cpp). On the same scenes errors are 0.2 to 35 times the
// tolerance.
constexpr double local_fraction = 0.02;
constexpr double least_tolerance = 1e-13;
// Newton's method may leave this part of a step's tolerance in a stage. What it leaves adds up over steps, where no
// error test sees it: a stiff torsion spring of 95 rad at 1e-10 errs five times as much with ARKODE's own 0.1, which
// saves 6 % of the evaluations.
constexpr double newton_share = 0.01;
// Corrections as small as this, relatively, are rounding.
constexpr double newton_rounding = 100 * std::numeric_limits<double>::epsilon();
constexpr double divergence = 2.3;  // of a correction over the one before; ARKODE's own

class Dirk;

// A vector that knows whose it is, and so do its clones: what ARKODE measures its error estimate with is an operation
// of vectors.
struct OwnedContent {
  _N_VectorContent_Serial serial;
  Dirk* owner;
};

void give(N_Vector v, Dirk* owner) {
  void* content = std::realloc(v->content, sizeof(OwnedContent));  // freed with the vector
  if (content == nullptr) throw std::bad_alloc();
  v->content = content;
  static_cast<OwnedContent*>(content)->owner = owner;
}

Dirk& owner(N_Vector v) { return *static_cast<OwnedContent*>(v->content)->owner; }

N_Vector clone(N_Vector v) {
  N_Vector w = sundials::made(N_VClone_Serial(v));
  give(w, &owner(v));
  return w;
}

class Dirk final : public ArkodeIntegrator {
 public:
  Dirk(Equations& system, const IntegratorOptions& options)
      : ArkodeIntegrator(system),
        linear_(y_.get(), context_),
        newton_(sundials::made(SUNNonlinSol_Newton(y_.get(), context_))),
        damped_(sundials::new_vector(system, context_)) {
    give(y_.get(), this);
    y_->ops->nvclone = clone;
    y_->ops->nvwrmsnorm = [](N_Vector x, N_Vector weights) { return owner(x).norm(x, weights); };
    const double tolerance = std::max(least_tolerance, local_fraction * options.tolerance);
    own(ARKStepCreate(nullptr, sundials::rhs, 0, y_.get(), context_), tolerance);
    // Order 5: a pair of order 4 (ESDIRK436L2SA) takes 1.6 times the evaluations at 1e-8, and where a fast oscillation
    // goes on undamped, so that errors of all steps add up, err ten times as much for them.
    ARKStepSetTableNum(memory_, ARKODE_ESDIRK547L2SA2_7_4_5, ARKODE_ERK_NONE);
    ARKodeSetSafetyFactor(memory_, safety);
    ARKodeSetNonlinearSolver(memory_, newton_.get());
    SUNNonlinSolSetConvTestFn(newton_.get(), converged, this);
    ARKodeSetMaxNonlinIters(memory_, most_iterations);
    ARKodeSetMaxConvFails(memory_, most_error_fails);  // Newton's method meets the same jumps
    ARKodeSetNonlinConvCoef(memory_, std::max(newton_share, newton_rounding / tolerance));
    ARKodeSetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
    ARKodeSetJacFn(memory_, sundials::jacobian);
    // A stage's derivative from the equation that the stage solves. Evaluated once more, it would multiply what
    // Newton's method has left by the fastest rate (Hairer & Wanner 1996, sec. IV.8).
    ARKodeSetDeduceImplicitRhs(memory_, 1);
  }

  // Newton's matrix serves over many steps.
  bool will_have_history() const override { return true; }
  bool has_history() const override { return !fresh_; }

 private:
  // Hairer & Wanner 1996, (IV.8.10): with corrections d_m and their quotient r = d_m / d_(m-1), what is left is at most
  // r / (1 - r) d_m. The quotient is that of this stage. ARKODE's own test takes one of a stage before, up to 20 steps
  // ago: where factors were exact it says that any first correction is as good as exact, and holds when step or
  // Jacobian have changed since (an oscillator at 1e-9: an error of 1e-3 in one step, none of it in the error
  // estimate).
  static int converged(SUNNonlinearSolver newton, N_Vector, N_Vector correction, sunrealtype enough, N_Vector weights,
                       void* self) {
    Dirk& dirk = *static_cast<Dirk*>(self);
    const double size = N_VWrmsNorm_Serial(correction, weights);
    const double last = dirk.last_correction_;
    int iteration = 0;
    SUNNonlinSolGetCurIter(newton, &iteration);
    if (iteration == 0 ? size <= enough : size * size <= enough * (last - size)) {
      dirk.estimate_due_ = true;
      return SUN_SUCCESS;
    }
    if (iteration > 0 && size > divergence * last) return SUN_NLS_CONV_RECVR;
    dirk.last_correction_ = size;
    return SUN_NLS_CONTINUE;
  }

  // ARKODE measures its error estimate next after the last stage, and that is damped here before; anything else is
  // measured as it is. In a component that decays within the step the estimate is the difference of two interpolations,
  // h^3 of its motion; the step's own error is smaller by that decay, which (I - h a J)^-1, whose factors are at hand,
  // brings about (Hosea & Shampine 1996; Hairer & Wanner 1996, sec. IV.8). Twice: stiff springs and dampers act on a
  // coordinate through its speed.
  double norm(N_Vector x, N_Vector weights) {
    if (!estimate_due_) return N_VWrmsNorm_Serial(x, weights);
    estimate_due_ = false;
    N_VScale(1, x, damped_.get());
    for (int i = 0; i < 2; ++i) {
      const int flag = SUNLinSolSolve(linear_.solver.get(), linear_.matrix.get(), damped_.get(), damped_.get(), 0);
      if (flag != SUN_SUCCESS) return N_VWrmsNorm_Serial(x, weights);
    }
    return N_VWrmsNorm_Serial(damped_.get(), weights);
  }

  void reinitialize(void* memory) override { ARKStepReInit(memory, nullptr, sundials::rhs, t_, y_.get()); }

  sundials::DenseSolver linear_;
  sundials::NonlinearSolver newton_;
  sundials::Vector damped_;
  double last_correction_ = 0;  // weighted
  bool estimate_due_ = false;
};

}  // namespace

std::unique_ptr<Integrator> make_dirk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Dirk>(system, options);
}

}  // namespace gelenk
