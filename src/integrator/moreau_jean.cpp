// SPDX-License-Identifier: BSD-3-Clause
// `moreau-jean`: fixed steps of the time-stepping scheme of Moreau and Jean (contact/time_stepper.h), projected after
// each. For contacts, of which there may be many: velocities jump at the ends of steps, and no event is located.
#include <stdexcept>

#include "integrator/fixed_step.h"

namespace gelenk {
namespace {

class MoreauJean final : public FixedStep {
 public:
  MoreauJean(Equations& system, const IntegratorOptions& options) : FixedStep(system, options), step_(options.step) {
    if (system.impulses() == nullptr) throw std::invalid_argument("these equations have no steps with impulses");
    system.impulses()->use(options.cone_tolerance);
  }
  void restart(double t, const double* y) override {
    FixedStep::restart(t, y);
    // Only once: a state that is restored has its forces.
    if (!started_) system_.impulses()->start(t, step_, y);
    started_ = true;
  }

 private:
  bool locates_events() const override { return false; }
  void make_step(double t, double h) override {
    if (!system_.impulses()->step(t, h, y_.data())) refuse(system_, t, y_.data(), "the velocities are not finite");
  }

  double step_;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<Integrator> make_moreau_jean(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<MoreauJean>(system, options);
}

}  // namespace gelenk
