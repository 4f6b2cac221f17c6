// SPDX-License-Identifier: BSD-3-Clause
// `auto` with contacts: located events or steps with impulses, by what happens.
#include <utility>
#include <vector>

#include "event/scheme_watch.h"
#include "integrator/controlled_steps.h"

namespace gelenk {
namespace {

// Steps between two decisions.
constexpr long steps_between_events = 10;
constexpr long steps_with_impulses = 10;

class ContactScheme final : public Integrator {
 public:
  ContactScheme(std::unique_ptr<Integrator> between_events, Equations& system, const IntegratorOptions& options)
      : system_(system),
        impulses_(*system.impulses()),
        between_events_(std::move(between_events)),
        with_impulses_(std::make_unique<ControlledSteps>(system, options, false)),
        y_(static_cast<std::size_t>(system.size())),
        start_(y_.size()),
        watch_(options.step) {}

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy_n(y, y_.size(), y_.begin());
    if (!started_) impulses_.change_to(false, t_, y_.data());
    started_ = true;
    present().restart(t_, y_.data());
  }
  void begin() override {
    between_events_->begin();
    with_impulses_->begin();
  }
  void inputs_changed() override { present().inputs_changed(); }
  void inputs_touched() override { present().inputs_touched(); }

  void warm_up(double end, double* y) override {
    const std::vector<double> start = y_;
    with_impulses_->restart(t_, start.data());
    impulses_.change_to(true, t_, start.data());
    with_impulses_->warm_up(end, y);
    impulses_.change_to(false, t_, start.data());
    std::ranges::copy(start, y);
    between_events_->restart(t_, y);
    between_events_->warm_up(end, y);
  }

  bool may_have_history() const override { return true; }
  bool will_have_history() const override { return !impulses_.are_used() && between_events_->will_have_history(); }
  bool has_history() const override { return !impulses_.are_used() && between_events_->has_history(); }

  SteppedTime stepped_time() const override { return with_impulses_->stepped_time(); }

  // After the equations, which know the present way.
  void serialize(Archive& archive) override {
    Integrator::serialize(archive);
    if (archive.reading()) {
      between_events_->restart(t_, y_.data());
      with_impulses_->restart(t_, y_.data());
    }
    between_events_->serialize(archive);
    with_impulses_->serialize(archive);
    watch_.serialize(archive);
  }

  double advance(double end, double* y) override {
    do {
      if (impulses_.are_used()) {
        step_towards(end);
      } else {
        locate_towards(end);
      }
    } while (t_ < end && !system_.budget_exhausted());
    steps_ = between_events_->steps() + with_impulses_->steps();
    rejected_ = between_events_->rejected_steps();
    std::ranges::copy(y_, y);
    return t_;
  }

 private:
  Integrator& present() { return impulses_.are_used() ? *with_impulses_ : *between_events_; }

  // Events are left before a step, not after one, and so are steps with impulses: at a communication point, the outputs
  // are those of the way that has led to it, since neither has forces before its first step.
  void locate_towards(double end) {
    const SchemeChange::Cause cause = watch_.too_many(impulses_.activity().closed);
    if (cause != SchemeChange::Cause::none) return leave_events(cause);
    const ImpulseEquations::Activity before = impulses_.activity();
    const double start = t_;
    std::ranges::copy(y_, start_.begin());
    const bool were_apart = impulses_.can_be_located_at(y_.data());
    try {
      t_ = between_events_->advance_some(end, y_.data(), steps_between_events);
    } catch (const IntegrationError& refusal) {
      if (!impulses_.take_over(before)) throw;
      leave_events(SchemeChange::Cause::refused);
      try {
        t_ = with_impulses_->advance_some(end, y_.data(), 1);
      } catch (const IntegrationError&) {
        throw IntegrationError(refusal);
      }
      return;
    }
    if (were_apart && !impulses_.can_be_located_at(y_.data())) return step_instead(start, before);
    const ImpulseEquations::Activity now = impulses_.activity();
    watch_.located(t_ - start, now.events.contacts - before.events.contacts);
  }

  // An event has been missed, so that shapes overlap.
  void step_instead(double start, const ImpulseEquations::Activity& before) {
    impulses_.forget_events(before);
    t_ = start;
    std::ranges::copy(start_, y_.begin());
    leave_events(SchemeChange::Cause::overlap);
  }

  void step_towards(double end) {
    if (watch_.is_quiet() && impulses_.can_be_located_at(y_.data())) return return_to_events();
    const long changes = with_impulses_->changes();
    const double start = t_;
    t_ = with_impulses_->advance_some(end, y_.data(), steps_with_impulses);
    const bool changed = with_impulses_->changes() != changes;
    watch_.stepped(t_ - start, changed, impulses_.activity().closed);
  }

  void return_to_events() {
    watch_.return_to_events();
    with_impulses_->end();
    impulses_.change_to(false, t_, y_.data());
    between_events_->restart(t_, y_.data());
  }

  void leave_events(SchemeChange::Cause cause) {
    watch_.leave_events();
    impulses_.change_to(true, t_, y_.data());
    with_impulses_->restart(t_, y_.data());
    with_impulses_->begin(cause);
  }

  Equations& system_;
  ImpulseEquations& impulses_;
  std::unique_ptr<Integrator> between_events_;
  std::unique_ptr<ControlledSteps> with_impulses_;
  std::vector<double> y_, start_;
  double t_ = 0;
  bool started_ = false;
  SchemeWatch watch_;
};

}  // namespace

std::unique_ptr<Integrator> make_contact_scheme(std::unique_ptr<Integrator> between_events, Equations& system,
                                                const IntegratorOptions& options) {
  return std::make_unique<ContactScheme>(std::move(between_events), system, options);
}

}  // namespace gelenk
