// SPDX-License-Identifier: BSD-3-Clause
// A Runge-Kutta starter for multistep methods (Gear 1980). A jump of the inputs makes their history worthless:
// continuing with it causes a dozen rejected steps of low order, restarting begins at order 1. Either way each jump
// costs some twenty steps, whose errors add up. Therefore the steps after a jump are made by `erk`, which has no
// history to lose; if jumps follow closely it makes all steps. If stability would limit these steps, the multistep
// method handles the jump itself.
#include "integrator/starter.h"
#include "event/step_course.h"

#include <algorithm>
#include <vector>

#include "formulation/fastest_rate.h"

namespace gelenk {
namespace {

// Runge-Kutta steps after a jump. They cost some five times as much as the start of the multistep method that follows,
// so starting is a small part of the run, however often inputs jump.
constexpr long starting_steps = 25;
// Number of them in one communication step from which stability is checked: fewer cost little anyway.
constexpr long min_steps_to_check = 5;
constexpr int most_jumps_between_trials = 1024;  // jumps between two trials, after stability was the limit
constexpr int max_check_interval = 64;           // starts between two checks, after it was not
// Near a singular configuration the weak direction of the constraints amplifies rounding to noise, and Newton's method
// and error tests fail again and again, however short the step. A method that neither solves equations nor predicts can
// cross it.
constexpr long window_attempts = 100;                // over which progress is measured
constexpr double max_failure_fraction = 0.15;        // of the attempts in a window
constexpr double min_progress_fraction = 0.03;       // relative to the best window
constexpr double stalled_progress_fraction = 0.003;  // the same without failures: rounding may shorten steps, too

class StartedMultistep final : public Integrator {
 public:
  StartedMultistep(std::unique_ptr<Integrator> multistep, Equations& system, const IntegratorOptions& options)
      : system_(system),
        multistep_(std::move(multistep)),
        erk_(make_erk(system, options)),
        y_(system.size()),
        y_before_(y_),
        course_(system.modes()),
        fastest_rate_(system) {}

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy_n(y, y_.size(), y_.begin());
    begin_multistep();
  }

  void begin() override {
    erk_->begin();
    multistep_->begin();
  }
  void inputs_changed() override { jumped_ = true; }
  void inputs_touched() override {
    if (using_starter_) erk_->inputs_touched();
  }
  double finest_tolerance() const override { return multistep_->finest_tolerance(); }

  void warm_up(double end, double* y) override {
    for (Integrator* method : {erk_.get(), multistep_.get()}) {
      method->restart(t_, y_.data());
      method->warm_up(end, y);
    }
  }

  bool may_have_history() const override { return true; }
  bool will_have_history() const override {
    if (jumped_) return !using_starter_ && !starts_.near();
    return !using_starter_ || steps_left_ == 0;
  }
  bool has_history() const override { return !using_starter_ && multistep_->has_history(); }

  void serialize(Archive& archive) override {
    Integrator::serialize(archive);
    archive.serialize(jumped_, using_starter_);
    archive.serialize_in_range(steps_left_, 0L, starting_steps);
    if (archive.reading() && using_starter_) erk_->restart(t_, y_.data());
    erk_->serialize(archive);
    multistep_->serialize(archive);
    starts_.serialize(archive);
    stability_checks_.serialize(archive);
    fastest_rate_.serialize(archive);
    archive.serialize(best_progress_, window_start_, window_start_steps_, window_start_rejected_);
  }

  double advance(double end, double* y) override {
    if (jumped_) handle_jump();
    do {
      if (using_starter_ && steps_left_ > 0) {
        advance_starter(end);
      } else {
        advance_multistep(end);
      }
    } while (t_ < end && !system_.budget_exhausted());
    steps_ = erk_->steps() + multistep_->steps();
    rejected_ = erk_->rejected_steps() + multistep_->rejected_steps();
    std::ranges::copy(y_, y);
    return t_;
  }

 private:
  void handle_jump() {
    jumped_ = false;
    if (using_starter_) {
      erk_->inputs_changed();
    } else if (starts_.due()) {
      erk_->restart(t_, y_.data());
      using_starter_ = true;
    } else {
      multistep_->inputs_changed();
      return;
    }
    steps_left_ = starting_steps;
  }

  // The last step of the multistep method went beyond an event: it is repeated by erk, which can take steps back
  // without loss.
  void repeat_with_starter(double t) {
    t_ = t;
    y_ = y_before_;
    erk_->restart(t_, y_.data());
    using_starter_ = true;
    steps_left_ = starting_steps;
  }

  // Makes a step of the multistep method in the mode in which it begins; returns whether it went beyond the end of the
  // mode.
  bool step_in_mode(double end) {
    if (course_.begin(t_, y_.data())) multistep_->restart(t_, y_.data());
    y_before_ = y_;
    const HeldMode held(system_.modes(), t_, course_.mode());
    const double longest = system_.modes().longest_step(t_, y_.data(), multistep_->slow_sliding());
    t_ = multistep_->advance_some(std::min(end, t_ + longest), y_.data(), 1);
    course_.end(t_, y_.data());
    if (system_.modes().mode_exit_time() < t_ || course_.any_changed() || course_.touch(course_.size()) < t_)
      return true;
    return system_.modes().touch_within(course_.start(), y_before_.data(), t_, y_.data()) < t_;
  }

  void advance_starter(double end) {
    const double from = t_;
    const long before = erk_->steps();
    try {
      t_ = erk_->advance_some(end, y_.data(), steps_left_);
    } catch (const RefusedMotion&) {
      throw;
    } catch (const IntegrationError&) {
      reject_starter();  // the other method may succeed
      return;
    }
    const long made = erk_->steps() - before;
    steps_left_ = std::max(0L, steps_left_ - made);  // repeated steps count, too
    if (made < min_steps_to_check || !stability_checks_.due()) return;
    if (fastest_rate_.at(t_, y_.data()) * (t_ - from) > stability_check_limit * static_cast<double>(made)) {
      reject_starter();
    } else {
      stability_checks_.failed();
      starts_.succeeded();
    }
  }

  void reject_starter() {
    begin_multistep();
    starts_.failed();
    stability_checks_.succeeded();
  }

  void begin_multistep() {
    multistep_->restart(t_, y_.data());
    using_starter_ = false;
    open_window();
  }

  void advance_multistep(double end) {
    if (using_starter_) begin_multistep();
    const double before = t_;
    // If stability would limit erk's steps, the multistep method locates events itself; it also ends steps at breaks.
    const bool passes_events = course_.size() > 0 && starts_.near() && !system_.modes().has_breaks();
    multistep_->pass_events(passes_events);
    bool passed_event = false;
    try {
      if (passes_events) {
        passed_event = step_in_mode(end);
      } else {
        t_ = multistep_->advance_some(end, y_.data(), 1);
      }
    } catch (const RefusedMotion&) {
      throw;
    } catch (const IntegrationError& error) {
      if (!cross_with_starter(end)) throw IntegrationError(error);
      return;
    }
    if (passed_event) {
      repeat_with_starter(before);
      return;
    }
    const long made = multistep_->steps();
    const long failed = multistep_->rejected_steps();
    if (made + failed < window_start_steps_ + window_start_rejected_ + window_attempts) return;
    const double progress = t_ - window_start_;
    best_progress_ = std::max(best_progress_, progress);
    const bool fails = static_cast<double>(failed - window_start_rejected_) > max_failure_fraction * window_attempts;
    const bool stuck = progress < (fails ? min_progress_fraction : stalled_progress_fraction) * best_progress_;
    if (!stuck || !cross_with_starter(end)) open_window();
  }

  void open_window() {
    window_start_ = t_;
    window_start_steps_ = multistep_->steps();
    window_start_rejected_ = multistep_->rejected_steps();
  }

  // Makes some steps with the starter; returns false if they fail.
  bool cross_with_starter(double end) {
    erk_->restart(t_, y_.data());
    try {
      t_ = erk_->advance_some(end, y_.data(), starting_steps);
    } catch (const RefusedMotion&) {
      throw;
    } catch (const IntegrationError&) {
      return false;
    }
    begin_multistep();
    return true;
  }

  Equations& system_;
  std::unique_ptr<Integrator> multistep_, erk_;
  double t_ = 0;
  std::vector<double> y_, y_before_;  // before the last step of the multistep method
  StepCourse course_;
  bool jumped_ = false;
  bool using_starter_ = false;  // erk made the last step
  long steps_left_ = 0;         // number of starter steps left
  Backoff starts_{4, most_jumps_between_trials};
  Backoff stability_checks_{2, max_check_interval};
  FastestRate fastest_rate_;
  double window_start_ = 0;                                  // s
  long window_start_steps_ = 0, window_start_rejected_ = 0;  // steps of the multistep method before the window
  double best_progress_ = 0;                                 // s: largest progress in a window
};

}  // namespace

std::unique_ptr<Integrator> with_starter(std::unique_ptr<Integrator> multistep, Equations& system,
                                         const IntegratorOptions& options) {
  if (system.multipliers() > 0) return multistep;
  return std::make_unique<StartedMultistep>(std::move(multistep), system, options);
}

}  // namespace gelenk
