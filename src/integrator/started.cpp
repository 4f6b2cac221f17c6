// SPDX-License-Identifier: BSD-3-Clause
// A Runge-Kutta starter for multistep methods (Gear 1980). A jump of the inputs makes their history worthless: what
// goes on with it meets the jump as an error, in a dozen rejected steps of low order; what begins anew does so at order
// 1. Either way each jump costs some twenty steps, whose errors add up. So the steps after a jump are made by `erk`,
// which has no history to lose, and where jumps follow closely it makes them all. Where stability would bind these
// steps, the multistep method meets the jump itself.
#include "integrator/started.h"
#include "event/step_course.h"

#include <algorithm>
#include <vector>

#include "integrator/fastest_rate.h"

namespace gelenk {
namespace {

// Runge-Kutta steps after a jump. They cost some five times as much as it then takes the multistep method to begin: so
// beginning is a small part of the run, however often inputs jump.
constexpr long starting_steps = 25;
// Of them in one communication step, from which on it is asked whether stability binds them: fewer are cheap anyway.
constexpr long many_steps = 5;
constexpr int longest_wait = 1024;      // jumps between two trials, where it did
constexpr int longest_confidence = 64;  // starts between two questions, where it did not
// Beside a singular position the rows' weak direction turns rounding into noise, and Newton's method and error tests
// fail again and again, however short the step. A method that solves no equations and predicts nothing passes.
constexpr long window = 100;            // attempts
constexpr double most_failures = 0.15;  // share of them
constexpr double least_way = 0.03;      // share of that of the best window
constexpr double no_way = 0.003;        // likewise: rounding shortens steps without a failure, too

class Started final : public Integrator {
 public:
  Started(std::unique_ptr<Integrator> multistep, Equations& system, const IntegratorOptions& options)
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

  void inputs_changed() override { jumped_ = true; }
  double finest_tolerance() const override { return multistep_->finest_tolerance(); }

  void warm_up(double end, double* y) override {
    for (Integrator* method : {erk_.get(), multistep_.get()}) {
      method->restart(t_, y_.data());
      method->warm_up(end, y);
    }
  }

  bool may_have_history() const override { return true; }
  bool will_have_history() const override {
    if (jumped_) return !starting_ && !starts_.near();
    return !starting_ || left_ == 0;
  }
  bool has_history() const override { return !starting_ && multistep_->has_history(); }

  void serialize(Archive& archive) override {
    Integrator::serialize(archive);
    archive.serialize(jumped_, starting_);
    archive.serialize_in_range(left_, 0L, starting_steps);
    if (archive.reading() && starting_) erk_->restart(t_, y_.data());
    erk_->serialize(archive);
    multistep_->serialize(archive);
    starts_.serialize(archive);
    questions_.serialize(archive);
    fastest_rate_.serialize(archive);
    archive.serialize(farthest_);
    open_window();
  }

  double advance(double end, double* y) override {
    if (jumped_) meet_jump();
    do {
      if (starting_ && left_ > 0) {
        start(end);
      } else {
        go_on(end);
      }
    } while (t_ < end && !system_.budget_exhausted());
    steps_ = erk_->steps() + multistep_->steps();
    rejected_ = erk_->rejected_steps() + multistep_->rejected_steps();
    std::ranges::copy(y_, y);
    return t_;
  }

 private:
  void meet_jump() {
    jumped_ = false;
    if (starting_) {
      erk_->inputs_changed();
    } else if (starts_.due()) {
      erk_->restart(t_, y_.data());
      starting_ = true;
    } else {
      multistep_->inputs_changed();
      return;
    }
    left_ = starting_steps;
  }

  // The multistep method's last step has gone beyond an event: it is made by erk, which can take steps back at no loss.
  void meet_event(double t) {
    t_ = t;
    y_ = y_before_;
    erk_->restart(t_, y_.data());
    starting_ = true;
    left_ = starting_steps;
  }

  // A step of the multistep method in the mode in which it begins; whether it has gone beyond the mode's end.
  bool step_in_mode(double end) {
    y_before_ = y_;
    course_.begin(t_, y_.data());
    const HeldMode held(system_.modes(), t_, course_.mode());
    t_ = multistep_->advance_some(end, y_.data(), 1);
    course_.end(t_, y_.data());
    return system_.modes().left_mode() < t_ || course_.any_changed() || course_.touch() < t_;
  }

  void start(double end) {
    const double from = t_;
    const long before = erk_->steps();
    try {
      t_ = erk_->advance_some(end, y_.data(), left_);
    } catch (const IntegrationError&) {
      give_up();  // perhaps the other can
      return;
    }
    const long made = erk_->steps() - before;
    left_ = std::max(0L, left_ - made);  // steps made again at kinks are counted, too
    if (made < many_steps || !questions_.due()) return;
    if (fastest_rate_.at(t_, y_.data()) * (t_ - from) > suspicious_reach * static_cast<double>(made)) {
      give_up();
    } else {
      questions_.failed();
      starts_.succeeded();
    }
  }

  void give_up() {
    begin_multistep();
    starts_.failed();
    questions_.succeeded();
  }

  void begin_multistep() {
    multistep_->restart(t_, y_.data());
    starting_ = false;
    open_window();
  }

  void go_on(double end) {
    if (starting_) begin_multistep();
    const double before = t_;
    // Where stability would bind erk's steps the multistep method goes back to events itself.
    const bool passes_events = course_.size() > 0 && starts_.near();
    multistep_->pass_events(passes_events);
    bool is_beyond = false;
    try {
      if (passes_events) {
        is_beyond = step_in_mode(end);
      } else {
        t_ = multistep_->advance_some(end, y_.data(), 1);
      }
    } catch (const IntegrationError& fault) {
      if (!pass_by_starter(end)) throw IntegrationError(fault);
      return;
    }
    if (is_beyond) {
      meet_event(before);
      return;
    }
    const long made = multistep_->steps();
    const long failed = multistep_->rejected_steps();
    if (made + failed < window_made_ + window_failed_ + window) return;
    const double way = t_ - window_start_;
    farthest_ = std::max(farthest_, way);
    const bool fails = static_cast<double>(failed - window_failed_) > most_failures * window;
    const bool stuck = way < (fails ? least_way : no_way) * farthest_;
    if (!stuck || !pass_by_starter(end)) open_window();
  }

  void open_window() {
    window_start_ = t_;
    window_made_ = multistep_->steps();
    window_failed_ = multistep_->rejected_steps();
  }

  // Some steps. False: they cannot be made.
  bool pass_by_starter(double end) {
    erk_->restart(t_, y_.data());
    try {
      t_ = erk_->advance_some(end, y_.data(), starting_steps);
    } catch (const IntegrationError&) {
      return false;
    }
    begin_multistep();
    return true;
  }

  Equations& system_;
  std::unique_ptr<Integrator> multistep_, erk_;
  double t_ = 0;
  std::vector<double> y_, y_before_;  // before the multistep method's last step
  StepCourse course_;
  bool jumped_ = false;
  bool starting_ = false;  // erk has made the last step
  long left_ = 0;          // of its steps, then
  Backoff starts_{4, longest_wait};
  Backoff questions_{2, longest_confidence};
  FastestRate fastest_rate_;
  double window_start_ = 0;                   // s
  long window_made_ = 0, window_failed_ = 0;  // steps of the multistep method before the window
  double farthest_ = 0;                       // s, that a window has come
};

}  // namespace

std::unique_ptr<Integrator> with_starter(std::unique_ptr<Integrator> multistep, Equations& system,
                                         const IntegratorOptions& options) {
  if (system.multipliers() > 0) return multistep;
  return std::make_unique<Started>(std::move(multistep), system, options);
}

}  // namespace gelenk
