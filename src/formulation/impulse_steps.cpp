// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/impulse_steps.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

void ImpulseSteps::use(double cone_tolerance) {
  stepper_ = std::make_unique<TimeStepper>(with_.mechanism, with_.dynamics, with_.loads, cone_tolerance);
  if (!with_.locks.empty()) with_.locks.release();
}

// Finds them by a trial step.
void ImpulseSteps::start(double t, double h, const double* y) {
  trial_.assign(y, y + with_.mechanism.nq + with_.mechanism.nv);
  stepper_->forget();
  step(t, h, trial_.data());
}

bool ImpulseSteps::step(double t, double h, double* y) {
  const auto finite = [&] {
    return std::all_of(y, y + with_.mechanism.nq + with_.mechanism.nv, [](double x) { return std::isfinite(x); });
  };
  if (!finite()) return false;
  with_.drives.go_to(t + h / 2);
  const bool made = stepper_->step(h, with_.drives.u().data(), y);
  return made && finite();
}

void ImpulseSteps::serialize(Archive& archive) {
  if (are_available()) stepper_->serialize(archive);
}

ImpulseSteps::AppliedForces::AppliedForces(ImpulseSteps& steps)
    : rows_(steps.with_.dynamics.branching().contact_rows()) {
  const ContactState& state = steps.stepper_->state();
  rows_.apply_forces(steps.are_required() ? state.wrenches.data() : nullptr, state.along.data());
}

ImpulseSteps::AppliedForces::~AppliedForces() { rows_.apply_forces(nullptr, nullptr); }

}  // namespace gelenk
