// SPDX-License-Identifier: BSD-3-Clause
// L-stable diagonally implicit Runge-Kutta with adaptive steps (ARKODE's ARKStep), projected after each accepted
// step. For stiff scenes whose inputs jump often: nothing is lost at a jump, where a multistep method's history is.
#include <arkode/arkode_arkstep.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <limits>

#include "integrator/arkode_integrator.h"

namespace gelenk {
namespace {

// On the stiff flyball governor, 10 s at 1e-6, 3 iterations (ARKODE's own limit) give 1686 steps and as many failures
// of Newton's method as Jacobians, 10 give 264; tables of order 5 (ESDIRK547L2SA2) take twice the evaluations there.
constexpr int most_iterations = 10;
constexpr double safety = 0.8;  // with ARKODE's own 0.96 more steps are rejected
// The local error test's share of the tolerance (see ida.cpp). On the same scenes errors are 0.5 to 220 times the
// tolerance.
constexpr double local_share = 0.05;
constexpr double least_tolerance = 1e-13;
// Newton's method may leave this part of a step's tolerance in a stage. Errors that it leaves add up over steps, where
// the error test cannot see them: with ARKODE's own 0.1 a stiff torsion spring of 95 rad errs by 110 times a tolerance
// of 1e-10, with this by 20 times, for 6 % more evaluations.
constexpr double newton_share = 0.01;
// Corrections as small as this, relatively, are rounding.
constexpr double newton_rounding = 100 * std::numeric_limits<double>::epsilon();
constexpr double divergence = 2.3;  // of a correction over the one before; ARKODE's own

class Dirk final : public ArkodeIntegrator {
 public:
  Dirk(Equations& system, const IntegratorOptions& options)
      : ArkodeIntegrator(system),
        linear_(y_.get(), context_),
        newton_(sundials::made(SUNNonlinSol_Newton(y_.get(), context_))) {
    const double tolerance = std::max(least_tolerance, local_share * options.tolerance);
    own(ARKStepCreate(nullptr, rhs, 0, y_.get(), context_), tolerance);
    ARKStepSetTableNum(memory_, ARKODE_ESDIRK436L2SA_6_3_4, ARKODE_ERK_NONE);
    ARKodeSetSafetyFactor(memory_, safety);
    ARKodeSetNonlinearSolver(memory_, newton_.get());
    SUNNonlinSolSetConvTestFn(newton_.get(), converged, &last_correction_);
    ARKodeSetMaxNonlinIters(memory_, most_iterations);
    ARKodeSetNonlinConvCoef(memory_, std::max(newton_share, newton_rounding / tolerance));
    ARKodeSetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
    ARKodeSetJacFn(memory_, jacobian);
    // A stage's derivative from the equation that the stage solves. Evaluated once more, it would multiply what
    // Newton's method has left by the fastest rate (Hairer & Wanner 1996, sec. IV.8).
    ARKodeSetDeduceImplicitRhs(memory_, 1);
  }

 private:
  // Hairer & Wanner 1996, (IV.8.10): with corrections d_m and their quotient r = d_m / d_(m-1), what is left is at most
  // r / (1 - r) d_m. The quotient is that of this stage. ARKODE's own test takes one of a stage before, up to 20 steps
  // ago: where factors were exact it says that any first correction is as good as exact, and holds when step or
  // Jacobian have changed since (an oscillator at 1e-9: an error of 1e-3 in one step, none of it in the error
  // estimate).
  static int converged(SUNNonlinearSolver newton, N_Vector, N_Vector correction, sunrealtype enough, N_Vector weights,
                       void* last_correction) {
    double& last = *static_cast<double*>(last_correction);
    const double size = N_VWrmsNorm(correction, weights);
    int iteration = 0;
    SUNNonlinSolGetCurIter(newton, &iteration);
    if (iteration == 0) {
      if (size <= enough) return SUN_SUCCESS;
    } else {
      if (size * size <= enough * (last - size)) return SUN_SUCCESS;
      if (size > divergence * last) return SUN_NLS_CONV_RECVR;
    }
    last = size;
    return SUN_NLS_CONTINUE;
  }

  void reinitialise(void* memory) override { ARKStepReInit(memory, nullptr, rhs, t_, y_.get()); }

  sundials::DenseSolver linear_;
  sundials::NonlinearSolver newton_;
  double last_correction_ = 0;  // weighted
};

}  // namespace

std::unique_ptr<Integrator> make_dirk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Dirk>(system, options);
}

}  // namespace gelenk
