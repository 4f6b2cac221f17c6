// SPDX-License-Identifier: BSD-3-Clause
// `auto`: the explicit method, until an implicit one is cheaper. What each costs is counted while it runs, as
// evaluations per simulated second, so the choice follows from what the run meets: stiffness that comes and goes,
// inputs that jump, communication steps. Counts, not clocks: the same calls give the same bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "integrator/fastest_rate.h"
#include "integrator/integrator.h"

namespace gelenk {
namespace {

constexpr int stretch_steps = 100;     // what a price is taken from
constexpr double stages = 13;          // of an explicit step of order 8
constexpr double accuracy_margin = 4;  // by which accuracy keeps explicit steps shorter than stability does
constexpr double clearly = 0.8;        // by this much a method has to be cheaper to be changed to
constexpr int longest_wait = 1 << 10;  // stretches between two trials that did not pay
// Up to so many equations the implicit method, whose matrices are full, is ready from the start; beyond it is made when
// it is needed, which asks of the heap within a step.
constexpr int most_ready = 1000;

// Costs in evaluations: measured on the flyball governor.
constexpr std::array<double, 2> cost_of_step = {1, 3};
double cost_of_jacobian(int size) { return 2.0 * size; }

// Hands calls on and counts what they cost.
class EvaluationCounter final : public Equations {
 public:
  explicit EvaluationCounter(Equations& counted) : counter_(counted) {}
  double cost() const { return static_cast<double>(evaluations_) + cost_of_jacobian(size()) * jacobians_; }

  int size() const override { return counter_.size(); }
  int coordinates() const override { return counter_.coordinates(); }
  bool rhs(double t, const double* y, double* ydot) override {
    ++evaluations_;
    return counter_.rhs(t, y, ydot);
  }
  bool jacobian(double t, const double* y, double* J) override {
    ++jacobians_;
    return counter_.jacobian(t, y, J);
  }
  bool project(double t, double* y) override { return counter_.project(t, y); }
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
    if (n_ <= most_ready) make_implicit();
  }

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy_n(y, n_, y_.begin());
    methods_[current_]->restart(t_, y_.data());
    stretch_ = {};
  }

  void inputs_changed() override { methods_[current_]->inputs_changed(); }

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
    if (!both) methods_[implicit_method].reset();  // made after the record
    if (archive.reading()) methods_[current_]->restart(t_, y_.data());
    methods_[explicit_method]->serialize(archive);
    if (both) methods_[implicit_method]->serialize(archive);
    archive.serialize(stretch_.time, stretch_.cost, stretch_.steps, price_);
    fastest_rate_.serialize(archive);
    archive.serialize(trial_);
    trials_.serialize(archive);
  }

  double advance(double end, double* y) override {
    do {
      go_on(end);
      if (stretch_.steps >= stretch_steps) review();
    } while (t_ < end && !counter_.budget_exhausted());
    count();
    std::ranges::copy(y_, y);
    return t_;
  }

 private:
  enum Method { explicit_method, implicit_method };
  struct Stretch {
    double time = 0, cost = 0;  // s; evaluations
    long steps = 0;
    double price() const { return cost / time; }
  };

  void go_on(double end) {
    const double cost = counter_.cost();
    const long steps = methods_[current_]->steps();
    const double start = t_;
    try {
      t_ = methods_[current_]->advance_some(end, y_.data(), stretch_steps - stretch_.steps);
    } catch (const IntegrationError& first) {
      change_to(1 - current_);  // perhaps the other can
      try {
        t_ = methods_[current_]->advance_some(end, y_.data(), stretch_steps);
      } catch (const IntegrationError&) {
        throw IntegrationError(first);
      }
      trial_ = 0;
      stretch_ = {};
      return;
    }
    stretch_.time += t_ - start;
    stretch_.steps += methods_[current_]->steps() - steps;
    stretch_.cost += counter_.cost() - cost;
  }

  // After each stretch: whether another method is worth a trial, or the trial was.
  void review() {
    stretch_.cost += cost_of_step[current_] * static_cast<double>(stretch_.steps);
    const Stretch last = stretch_;
    stretch_ = {};
    const bool on_trial = trial_ > 0;
    if (on_trial) --trial_;
    if (trial_ > 0) return;  // a multistep method starts with small steps
    const double before = price_[1 - current_];
    price_[current_] = last.price();
    if (on_trial) {
      if (price_[current_] < clearly * before) {
        trials_.succeeded();
      } else {
        trials_.failed();
        change_to(1 - current_);
      }
      return;
    }
    if (!trials_.due()) return;
    if (current_ == explicit_method) {
      if (fastest_rate_.at(t_, y_.data()) * last.time > suspicious_reach * static_cast<double>(last.steps))
        attempt(implicit_method);
    } else if (clearly * price_[current_] > before || clearly * price_[current_] > least_explicit_price()) {
      attempt(explicit_method);
    }
  }

  // What stability asks of the explicit method.
  double least_explicit_price() { return accuracy_margin * stages * fastest_rate_.at(t_, y_.data()) / stable_reach; }

  void attempt(int method) {
    trial_ = 2;
    change_to(method);
  }

  void make_implicit() {
    if (!methods_[implicit_method]) methods_[implicit_method] = make_cvode(counter_, options_);
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
  Stretch stretch_;
  std::array<double, 2> price_ = {INFINITY, INFINITY};  // evaluations per simulated second, when last used
  int trial_ = 0;                                       // stretches of a trial that are still to come
  Backoff trials_{4, longest_wait};
  FastestRate fastest_rate_;
};

}  // namespace

std::unique_ptr<Integrator> make_automatic(Equations& system, const IntegratorOptions& options) {
  if (system.multipliers() > 0) return make_ida(system, options);
  return std::make_unique<Automatic>(system, options);
}

}  // namespace gelenk
