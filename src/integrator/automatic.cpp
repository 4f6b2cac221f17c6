// SPDX-License-Identifier: BSD-3-Clause
// `auto`: the explicit method, until an implicit one is less expensive. Costs are counted during the run, as
// evaluations per simulated second, so the choice follows from the run itself: stiffness that comes and goes, inputs
// that jump, communication steps. Evaluations are counted rather than time, so that the same calls give the same bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "formulation/fastest_rate.h"
#include "integrator/controlled_steps.h"
#include "integrator/starter.h"

namespace gelenk {
namespace {

constexpr int window_steps = 100;  // steps over which a cost is measured, at least
// The same at most, of an implicit method after a jump of inputs: its steps are short and become long, so that the cost
// of the first hundred is not that of a second, and the window extends to the end of the communication step.
constexpr int longest_window = 1000;
constexpr double stages = 13;          // of an explicit step of order 8
constexpr double accuracy_margin = 4;  // factor by which accuracy limits explicit steps more than stability does
constexpr double required_gain = 0.8;  // a method must cost less than this fraction to be switched to
constexpr double changed_cost = 100;   // of the other method in its last trial, above which another one is due
constexpr int most_windows_between_trials = 1 << 10;  // windows between two unsuccessful trials
// For systems up to this size the implicit method, whose matrices are dense, is created at the start; for larger ones
// when it is needed, which allocates memory within a step.
constexpr int max_size_prepared = 1000;

// Overhead of a step and cost of a Jacobian in evaluations: measured on the flyball governor.
constexpr std::array<double, 2> cost_of_step = {1, 3};
double cost_of_jacobian(int size) { return 2.0 * size; }

// Forwards all calls and counts the evaluations.
class EvaluationCounter final : public Equations {
 public:
  explicit EvaluationCounter(Equations& counted) : counter_(counted) {}
  double cost() const { return static_cast<double>(evaluations_) + cost_of_jacobian(size()) * jacobians_; }

  int size() const override { return counter_.size(); }
  int coordinates() const override { return counter_.coordinates(); }
  int velocities() const override { return counter_.velocities(); }
  bool rhs(double t, const double* y, double* ydot) override {
    ++evaluations_;
    return counter_.rhs(t, y, ydot);
  }
  bool jacobian(double t, const double* y, double* J) override {
    ++jacobians_;
    return counter_.jacobian(t, y, J);
  }
  bool jacobian_is_outdated() override { return counter_.jacobian_is_outdated(); }
  bool project(double t, double* y) override { return counter_.project(t, y); }
  void polish(bool on) override { counter_.polish(on); }
  double end_of_step(double t) override { return counter_.end_of_step(t); }
  void displace(double* q, const double* dv) const override { counter_.displace(q, dv); }
  void accepted(double t, const double* y) override { counter_.accepted(t, y); }
  bool budget_exhausted() const override { return counter_.budget_exhausted(); }
  EventSource& modes() override { return counter_.modes(); }
  std::string obstacle(const double* y) override { return counter_.obstacle(y); }

 private:
  Equations& counter_;
  long evaluations_ = 0;
  long jacobians_ = 0;
};

class Automatic final : public Integrator {
 public:
  Automatic(Equations& system, const IntegratorOptions& options)
      : counter_(system),
        options_(options),
        methods_{make_erk(counter_, options), nullptr},
        n_(system.size()),
        y_(n_),
        fastest_rate_(system) {
    if (n_ <= max_size_prepared) make_implicit();
  }

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy_n(y, n_, y_.begin());
    methods_[current_]->restart(t_, y_.data());
    window_ = {};
  }

  void begin() override {
    for (const auto& method : methods_) {
      if (method) method->begin();
    }
  }
  void inputs_changed() override {
    window_.has_jump = true;
    methods_[current_]->inputs_changed();
  }
  void inputs_touched() override { methods_[current_]->inputs_touched(); }

  void warm_up(double end, double* y) override {
    for (const auto& method : methods_) {
      if (!method) continue;
      method->restart(t_, y_.data());
      method->warm_up(end, y);
    }
  }

  bool may_have_history() const override { return true; }
  bool will_have_history() const override { return current_ == implicit_method; }
  bool has_history() const override { return methods_[current_]->has_history(); }

  void serialize(Archive& archive) override {
    Integrator::serialize(archive);
    archive.serialize_in_range(current_, 0, 1);
    bool both = methods_[implicit_method] != nullptr;
    archive.serialize(both);
    if (both) make_implicit();
    if (!both) methods_[implicit_method].reset();  // created after the state was saved
    if (archive.reading()) methods_[current_]->restart(t_, y_.data());
    methods_[explicit_method]->serialize(archive);
    if (both) methods_[implicit_method]->serialize(archive);
    archive.serialize(window_.time, window_.cost, window_.steps, window_.has_jump, cost_per_second_);
    fastest_rate_.serialize(archive);
    archive.serialize(probation_);
    trials_.serialize(archive);
  }

  double advance(double end, double* y) override { return advance_some(end, y, std::numeric_limits<long>::max()); }

  double advance_some(double end, double* y, long max_steps) override {
    long made = 0;
    do {
      const long steps = window_.steps;
      advance_window(end, max_steps - made);
      made += std::max(1L, window_.steps - steps);
      if (window_.steps >= (t_ < end ? most_steps() : window_steps)) review();
    } while (t_ < end && made < max_steps && !counter_.budget_exhausted());
    count();
    std::ranges::copy(y_, y);
    return t_;
  }

 private:
  enum Method { explicit_method, implicit_method };
  struct Window {
    double time = 0, cost = 0;  // s; evaluations
    long steps = 0;
    bool has_jump = false;
    double cost_per_second() const { return cost / time; }
  };

  int most_steps() const { return current_ == implicit_method && window_.has_jump ? longest_window : window_steps; }

  void advance_window(double end, long max_steps) {
    const double cost = counter_.cost();
    const long steps = methods_[current_]->steps();
    const double start = t_;
    try {
      t_ = methods_[current_]->advance_some(end, y_.data(), std::min(max_steps, most_steps() - window_.steps));
    } catch (const RefusedMotion&) {
      throw;
    } catch (const IntegrationError& first) {
      change_to(1 - current_);  // the other method may succeed
      window_ = {};
      try {
        t_ = methods_[current_]->advance_some(end, y_.data(), window_steps);
      } catch (const IntegrationError&) {
        throw IntegrationError(first);
      }
      probation_ = 0;
      return;
    }
    window_.time += t_ - start;
    window_.steps += methods_[current_]->steps() - steps;
    window_.cost += counter_.cost() - cost;
  }

  // Called after each window: decides whether another method is worth a trial, or whether the trial was successful.
  void review() {
    window_.cost += cost_of_step[current_] * static_cast<double>(window_.steps);
    const Window last = window_;
    window_ = {};
    const bool on_probation = probation_ > 0;
    if (on_probation) --probation_;
    if (probation_ > 0) return;  // a multistep method starts with small steps
    const double other_cost = cost_per_second_[1 - current_];
    cost_per_second_[current_] = last.cost_per_second();
    if (on_probation) {
      if (cost_per_second_[current_] < required_gain * other_cost) {
        trials_.succeeded();
      } else {
        trials_.failed();
        change_to(1 - current_);
      }
      return;
    }
    // A trial that failed says nothing where steps have become far shorter since.
    const bool has_changed = cost_per_second_[current_] > changed_cost * other_cost;
    if (!trials_.due() && !has_changed) return;
    if (current_ == explicit_method) {
      if (has_changed ||
          fastest_rate_.at(t_, y_.data()) * last.time > stability_check_limit * static_cast<double>(last.steps))
        start_trial(implicit_method);
    } else if (required_gain * cost_per_second_[current_] > other_cost ||
               required_gain * cost_per_second_[current_] > min_explicit_cost()) {
      start_trial(explicit_method);
    }
  }

  // Lower bound on the cost of the explicit method due to stability.
  double min_explicit_cost() { return accuracy_margin * stages * fastest_rate_.at(t_, y_.data()) / stability_limit; }

  void start_trial(int method) {
    probation_ = 2;
    change_to(method);
  }

  void make_implicit() {
    if (methods_[implicit_method]) return;
    std::unique_ptr<Integrator>& method = methods_[implicit_method];
    method = make_cvode(counter_, options_);
    // It cannot take back steps that go beyond events without losing its history.
    if (counter_.modes().indicators() > 0) method = with_starter(std::move(method), counter_, options_);
  }

  void change_to(int method) {
    if (method == implicit_method) make_implicit();
    current_ = method;
    methods_[current_]->restart(t_, y_.data());
  }

  void count() {
    steps_ = rejected_ = 0;
    for (const auto& method : methods_) {
      if (!method) continue;
      steps_ += method->steps();
      rejected_ += method->rejected_steps();
    }
  }

  EvaluationCounter counter_;
  IntegratorOptions options_;
  std::array<std::unique_ptr<Integrator>, 2> methods_;
  int n_;
  int current_ = explicit_method;
  double t_ = 0;
  std::vector<double> y_;
  Window window_;
  std::array<double, 2> cost_per_second_ = {INFINITY, INFINITY};  // evaluations per simulated second, at the last use
  int probation_ = 0;                                             // windows left in a trial
  Backoff trials_{4, most_windows_between_trials};
  FastestRate fastest_rate_;
};

}  // namespace

std::unique_ptr<Integrator> make_automatic(Equations& system, const IntegratorOptions& options) {
  if (system.multipliers() > 0) return make_ida(system, options);
  auto by_cost = [&] { return std::make_unique<Automatic>(system, options); };
  ImpulseEquations* const impulses = system.impulses();
  if (impulses == nullptr || !impulses->are_required() || impulses->must_be_located()) return by_cost();
  if (!impulses->may_be_located()) return std::make_unique<ControlledSteps>(system, options, true);
  return make_contact_scheme(by_cost(), system, options);
}

}  // namespace gelenk
