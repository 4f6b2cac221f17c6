// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/contact_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "event_driven/contact_modes.h"
#include "event_driven/event_modes.h"
#include "event_driven/mode_changes.h"
#include "kinematics/loads.h"
#include "time_stepping/shared_impulses.h"

namespace gelenk {

ContactMotion::ContactMotion(const ImpulseSteps::Context& context, EventModes& modes, bool located)
    : steps_(context),
      dynamics_(context.dynamics),
      links_(context.mechanism.links.size()),
      modes_(modes),
      located_(located ? &modes.contacts() : nullptr) {}

bool ContactMotion::must_be_located() const { return steps_.loads().need_events(); }

void ContactMotion::use(ImpulseAccuracy accuracy) {
  steps_.use(accuracy);
  steps_used_ = true;
}

void ContactMotion::change_to(bool impulses, double t, const double* y) {
  if (impulses == steps_used_) return;
  steps_used_ = impulses;
  steps_.forget();
  steps_.stepper().forget_second();
  if (impulses) {
    modes_.release();
  } else {
    modes_.start(t, y);
  }
}

ImpulseEquations::Activity ContactMotion::activity() const {
  Activity out{.closed = static_cast<int>(steps_.contact_points()),
               .changes = steps_.changes(),
               .events = steps_.events().counts()};
  if (!steps_used_) out.closed = static_cast<int>(located_->equations().closed().size());
  return out;
}

bool ContactMotion::can_be_located_at(const double* y) { return !located_->outputs().any_overlap(y); }

// Bounds beyond which no force can stop a motion, are no question of the method; nor are events of joints alone, or
// stiffness where nothing touches.
bool ContactMotion::take_over(const Activity& before) {
  if (steps_.locks().state().unstoppable >= 0) return false;
  const EventLog& events = steps_.events();
  const bool touch =
      !located_->equations().closed().empty() || before.closed > 0 || events.counts().contacts > before.events.contacts;
  const bool by_contacts = events.too_many().empty() ? touch : events.contacts_prevail();
  if (!by_contacts && modes_.changes().refusal().empty()) return false;
  forget_events(before);
  return true;
}

bool ContactMotion::touches() const { return located_ != nullptr && !located_->equations().closed().empty(); }

// Friction of joints that depends on loads follows the forces of contacts, and these follow it: with the former as
// loads, the latter are solved for again.
void ContactMotion::add_to(double* vdot, const std::function<void(double* vdot)>& solve) {
  constexpr int most_corrections = 40;
  constexpr double enough = 1e-13, rounding = 1e-10;  // changes of forces that end it; that may be rounding
  ContactEquations& equations = located_->equations();
  equations.accelerate(vdot);
  LoadDependence& loads = dynamics_.switching_forces().loads();
  if (loads.empty()) return;
  double change = INFINITY, before = INFINITY;
  for (int k = 0; k < most_corrections && change > enough && !(change <= rounding && change >= before); ++k) {
    apply_forces();
    solve(vdot);
    before = std::exchange(change, equations.accelerate(vdot, true));
  }
  withdraw_forces();
  if (!(change <= rounding)) loads.set_undetermined();
}

void ContactMotion::apply_forces() {
  ContactEquations& equations = located_->equations();
  wrenches_.assign(links_, Spatial::Force{});
  add_wrenches(equations, equations.forces(), wrenches_);
  dynamics_.switching_forces().contact_rows().apply_forces(wrenches_.data(), nullptr);
}

void ContactMotion::withdraw_forces() { dynamics_.switching_forces().contact_rows().apply_forces(nullptr, nullptr); }

std::vector<std::array<std::string, 2>> ContactMotion::event_texts(const std::vector<std::string>& bodies,
                                                                   const std::vector<std::string>& contacts) const {
  return located_ != nullptr ? located_->outputs().event_texts(bodies, contacts)
                             : std::vector<std::array<std::string, 2>>{};
}

ContactReadings& ContactMotion::PresentReadings::present() const {
  if (of_.located_ != nullptr && !of_.steps_used_) return of_.located_->outputs();
  return *of_.steps_.readings();
}

void ContactMotion::count(RunCounts& counts) const {
  counts.contact_points = static_cast<long>(steps_.contact_points());
  counts.cone_iterations = steps_.solved().iterations;
  counts.cone_residual = steps_.solved().residual;
  counts.scheme = steps_used_ ? 1 : 0;
  counts.ambiguous += steps_.events().shared_count();
  if (located_ == nullptr) return;
  const ModeCounts& of_events = modes_.changes().counts();
  counts.impacts += of_events.impacts;
  counts.closed_series += of_events.closed_series;
  counts.ambiguous += of_events.ambiguous;
  if (steps_used_) return;
  const ContactEquations& equations = located_->equations();
  counts.contact_points =
      std::ranges::count_if(equations.closed(), [&](int of) { return !equations.candidates()[of].is_given(); });
}

// Of located contacts whose forces are those of the present state, which they need not be beside friction that depends
// on loads.
void ContactMotion::report_shared_load(double t) {
  SwitchingForces& forces = dynamics_.switching_forces();
  std::optional<SharedLoad> shared;
  if (steps_used_) {
    if (steps_.are_available()) shared = SharedImpulses(steps_.stepper()).find();
  } else if (located_ != nullptr && modes_.locks().any_at_rest() && forces.loads().empty()) {
    shared = located_->outputs().shared_load();
  }
  if (!shared) return steps_.events().set_shared(SharedLoadEvent{.time = t});
  const SwitchingForces::Lock& lock = forces.lock(shared->lock);
  const bool is_latched = forces.hold_coordinate(shared->lock) || forces.engagement(shared->lock) > 0;
  const int force = is_latched && lock.latch >= 0 ? lock.latch : lock.friction >= 0 ? lock.friction : lock.limit;
  steps_.events().set_shared(SharedLoadEvent{t, shared->contact, force});
}

LawAudit ContactMotion::law_audit(double t, std::span<const double> v) {
  LawAudit out;
  report_shared_load(t);
  if (!steps_used_ || !steps_.are_available()) return out;
  const TimeStepper::Missed& missed = steps_.stepper().missed();
  out.add(missed.excess, {BrokenLaw::Kind::contact_approaches, missed.contact, missed.speed});
  const JointRows::Moving& moving = steps_.stepper().joints().moving_latch();
  if (moving.lock >= 0) out.add(audit_latch(dynamics_.switching_forces(), moving.lock, moving.speed, v));
  return out;
}

void ContactMotion::start() { steps_.forget(); }

void ContactMotion::serialize(Archive& archive) {
  steps_.serialize(archive);
  if (located_ != nullptr && steps_.are_available()) archive.serialize(steps_used_);
}

}  // namespace gelenk
