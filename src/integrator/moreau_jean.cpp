// SPDX-License-Identifier: BSD-3-Clause
// `moreau-jean`: fixed steps of the time-stepping scheme of Moreau and Jean (contact/time_stepper.h), projected after
// each. For contacts, of which there may be many: velocities jump at the ends of steps, and no event is located.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "integrator/fixed_step.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Steps longer than 2 / omega amplify a vibration of this circular frequency, which is known to a few percent.
constexpr double measured_stability_limit = 2 * 1.1;
// Steps between two determinations of the highest frequency, which then costs no more than some percent.
constexpr int steps_between_checks = 200;

class MoreauJean final : public FixedStep {
 public:
  MoreauJean(Equations& system, const IntegratorOptions& options) : FixedStep(system, options), step_(options.step) {
    if (system.impulses() == nullptr) throw std::invalid_argument("these equations have no steps with impulses");
    system.impulses()->use({.relative = options.cone_tolerance});
  }
  void restart(double t, const double* y) override {
    FixedStep::restart(t, y);
    until_check_ = 0;
    // Only once: a state that is restored has its forces.
    if (!started_) system_.impulses()->start(t, step_, y);
    started_ = true;
  }
  void inputs_changed() override { until_check_ = 0; }
  void serialize(Archive& archive) override {
    FixedStep::serialize(archive);
    archive.serialize_in_range(until_check_, 0, steps_between_checks);
  }

 private:
  bool locates_events() const override { return false; }
  void make_step(double t, double h) override {
    if (until_check_ == 0) check_stability(t, h);
    --until_check_;
    if (!system_.impulses()->step(t, h, y_.data()))
      refuse(system_, t, y_.data(), "velocities or forces are not finite, or too large for numbers");
  }

  // A vibration that these steps amplify would soon be all that is left of the motion.
  void check_stability(double t, double h) {
    until_check_ = steps_between_checks;
    const double omega = system_.impulses()->highest_frequency(t, y_.data());
    if (!(h * omega > measured_stability_limit)) return;
    throw IntegrationError(at_time(t) + "steps of " + text::rounded(h) + " s (solver.step) are unstable: the fastest " +
                           "vibration of the scene has " + text::rounded(omega / (2 * std::numbers::pi), 3) +
                           " Hz, expected at most " + text::rounded(2 / omega, 3) +
                           " s, or the integrator auto, which chooses its steps");
  }

  double step_;
  bool started_ = false;
  int until_check_ = 0;
};

}  // namespace

std::unique_ptr<Integrator> make_moreau_jean(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<MoreauJean>(system, options);
}

}  // namespace gelenk
