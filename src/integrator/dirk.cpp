// SPDX-License-Identifier: BSD-3-Clause
// L-stable diagonally implicit Runge-Kutta with adaptive steps (ARKODE's ARKStep), projected after each accepted
// step. For stiff scenes whose inputs jump often: nothing is lost at a jump, where a multistep method's history is.
#include <arkode/arkode_arkstep.h>

#include <algorithm>

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

class Dirk final : public ArkodeIntegrator {
 public:
  Dirk(Equations& system, const IntegratorOptions& options) : ArkodeIntegrator(system), linear_(y_.get(), context_) {
    own(ARKStepCreate(nullptr, rhs, 0, y_.get(), context_), std::max(least_tolerance, local_share * options.tolerance));
    ARKStepSetTableNum(memory_, ARKODE_ESDIRK436L2SA_6_3_4, ARKODE_ERK_NONE);
    ARKodeSetSafetyFactor(memory_, safety);
    ARKodeSetMaxNonlinIters(memory_, most_iterations);
    ARKodeSetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
    ARKodeSetJacFn(memory_, jacobian);
  }

 private:
  void reinitialise(void* memory) override { ARKStepReInit(memory, nullptr, rhs, t_, y_.get()); }

  sundials::DenseSolver linear_;
};

}  // namespace

std::unique_ptr<Integrator> make_dirk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Dirk>(system, options);
}

}  // namespace gelenk
