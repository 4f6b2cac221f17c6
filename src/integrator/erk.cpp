// SPDX-License-Identifier: BSD-3-Clause
// Explicit Runge-Kutta with adaptive steps (ARKODE's ERKStep), projected after each accepted step.
#include <arkode/arkode_erkstep.h>

#include "integrator/arkode_integrator.h"

namespace gelenk {
namespace {

// Of ARKODE's tables of order 5 to 9 these two gave the smallest error for the evaluations spent, on loops and trees
// (four-bar, slider-crank, Andrews' squeezer, double pendulum, heavy top, cart-pole): order 6 above, 8 below.
ARKODE_ERKTableID table_for(double tolerance) { return tolerance > 3e-7 ? ARKODE_VERNER_9_5_6 : ARKODE_VERNER_13_7_8; }

// With ARKODE's own 0.96 every third step was rejected on the same scenes. Controllers with a memory (PI, Gustafsson)
// do better still over long stretches, but lose it all where steps end at communication points: those steps are cut
// short, and their tiny errors mislead the next.
constexpr double safety = 0.8;

class Erk final : public ArkodeIntegrator {
 public:
  Erk(OdeSystem& system, const IntegratorOptions& options) : ArkodeIntegrator(system) {
    own(ERKStepCreate(rhs, 0, y_.get(), context_), options.tolerance);
    ERKStepSetTableNum(memory_, table_for(options.tolerance));
    ARKodeSetSafetyFactor(memory_, safety);
  }
};

}  // namespace

std::unique_ptr<Integrator> make_erk(OdeSystem& system, const IntegratorOptions& options) {
  return std::make_unique<Erk>(system, options);
}

}  // namespace gelenk
