// SPDX-License-Identifier: BSD-3-Clause
// Explicit Runge-Kutta with adaptive steps (ARKODE's ERKStep), projected after each accepted step. Of several embedded
// pairs, from few stages to many, the one is used that takes the run from one communication point to the next with the
// fewest evaluations: if these are close, one step of an inexpensive method is as good as one of an expensive method.
#include <arkode/arkode_erkstep.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "integrator/arkode_integrator.h"
#include "integrator/step_controller.h"

namespace gelenk {
namespace {

// The classical method (Kutta 1901), order 4. The best error estimate from its four stages is of order 3; the weights
// that yield h^3 y''' / 6 follow from the conditions of orders 1 to 3. A fraction of it is compared with the tolerance,
// so that errors are those of the other tables: four-bar and arm in steps of 1 ms, N-four-bars and a double pendulum in
// steps of 10 and 20 ms. The 3/8 rule and Kuntzmann's method did no better.
ARKodeButcherTable classical() {
  constexpr double error_fraction = 0.04;
  double c[] = {0, 1. / 2, 1. / 2, 1};
  double A[] = {0, 0, 0, 0, 1. / 2, 0, 0, 0, 0, 1. / 2, 0, 0, 0, 0, 1, 0};
  double b[] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  const double third[] = {2. / 3, -2. / 3, -2. / 3, 2. / 3};
  double d[4];
  for (int i = 0; i < 4; ++i) d[i] = b[i] - error_fraction * third[i];
  return sundials::made(ARKodeButcherTable_Create(4, 4, 2, c, A, b, d));
}

struct EmbeddedPair {
  ARKODE_ERKTableID table;  // ARKODE_ERK_NONE: the classical method above
  int stages;
  double tolerance_fraction;  // used in the local error test
  bool keeps_derivative;      // the last stage is the first one of the next step
  double loosest = 1;         // tolerance: at looser ones the fraction is that of this one
};

// Of ARKODE's tables of order 5 to 9 the last two gave the smallest error for a given number of evaluations on loops
// and trees (four-bar, slider-crank, Andrews' squeezer, double pendulum, heavy top, cart-pole): order 6 at loose
// tolerances, 8 at tight ones. The fractions are such that errors are within some tens of times the tolerance (see
// ida.cpp; here 0.1 to 22 times). The pairs of lower order take many small steps whose errors add up, so each step has
// to be more accurate. The error estimate of order 8 is too small in long steps: at 1e-7 it would let through errors
// ten times those of order 6 at 1e-6. As accurate as at 1e-8 it still takes fewer evaluations than order 6 at 3e-7.
constexpr std::array<EmbeddedPair, 4> embedded_pairs = {{
    {ARKODE_ERK_NONE, 4, 1, false},
    {ARKODE_CASH_KARP_6_4_5, 6, 0.03, false},
    {ARKODE_VERNER_9_5_6, 9, 0.1, true},
    {ARKODE_VERNER_13_7_8, 13, 0.1, false, 1e-8},
}};
// Below this the error test is dominated by rounding.
constexpr double erk_min_tolerance = 1e-13;

double local_tolerance(const EmbeddedPair& pair, double tolerance) {
  return std::max(erk_min_tolerance, pair.tolerance_fraction * std::min(tolerance, pair.loosest));
}
int highest_pair(double tolerance) { return tolerance > 3e-7 ? 2 : 3; }

// With it every twentieth step is rejected; with ARKODE's own 0.96, every fifth (scenes as above).
constexpr double erk_safety = 0.9;

// Step attempts of a lower pair in one communication step, above which the highest pair takes over.
constexpr long max_attempts = 6;
constexpr int most_steps_between_trials = 256;  // communication steps between two trials of another pair

class Erk final : public ArkodeIntegrator {
 public:
  Erk(Equations& system, const IntegratorOptions& options)
      : ArkodeIntegrator(system, gelenk::slow_sliding(options.tolerance, true)),
        top_(highest_pair(options.tolerance)),
        pair_(top_) {
    for (int i = 0; i <= top_; ++i) {
      adopt(ERKStepCreate(rhs, 0, y_.get(), context_), local_tolerance(embedded_pairs[i], options.tolerance));
      take_table(embedded_pairs[i].table);
      ARKodeSetSafetyFactor(memory_, erk_safety);
      controllers_[i] = sundials::make_step_controller(context_);
      ARKodeSetAdaptController(memory_, controllers_[i].get());
    }
  }

  void warm_up(double end, double* y) override {
    const double start = t_;
    const std::vector<double> from(y, y + system_.size());
    for (int i = 0; i <= top_; ++i) {
      switch_to(i, end - start);
      restart(start, from.data());
      advance_some(end, y, 1);
    }
  }

  void serialize(Archive& archive) override {
    archive.serialize_in_range(pair_, 0, top_);
    use(pair_, 0);
    long since = attempts() - attempts_before_;
    ArkodeIntegrator::serialize(archive);
    for (int i = 0; i <= top_; ++i) sundials::serialize(controllers_[i], archive);
    archive.serialize(since, length_, trial_, cost_before_);
    archive.serialize_in_range(pair_before_, 0, top_);
    trials_.serialize(archive);
    if (archive.reading()) attempts_before_ = attempts() - since;
  }

 private:
  void take_table(ARKODE_ERKTableID id) {
    if (id != ARKODE_ERK_NONE) {
      ERKStepSetTableNum(memory_, id);
      return;
    }
    const std::unique_ptr<ARKodeButcherTableMem, decltype(&ARKodeButcherTable_Free)> table(classical(),
                                                                                           ARKodeButcherTable_Free);
    ERKStepSetTable(memory_, table.get());
  }

  void reinitialize(void* memory) override { ERKStepReInit(memory, rhs, t_, y_.get()); }

  bool keeps_derivative() const override { return embedded_pairs[pair_].keeps_derivative; }

  double step_after_stop(std::size_t stepper) const override {
    return sundials::next_step(controllers_[stepper], erk_safety, growth(stepper));
  }

  void choose_stepper(double end) override {
    const double length = end - t_;
    const long steps = attempts() - attempts_before_;
    const bool same_length = steps > 0 && std::abs(length - length_) < 1e-6 * length;
    if (same_length) select_pair(length, steps * embedded_pairs[pair_].stages);
    length_ = length;
    attempts_before_ = attempts();
  }

  void reconsider_stepper() override {
    if (pair_ == top_ || attempts() - attempts_before_ < max_attempts) return;
    trial_ = false;
    length_ = 0;  // do not compare the next communication step with this one
    trials_.failed();
    switch_to(top_, current_step());
    attempts_before_ = attempts();
  }

  // cost: evaluations of the last communication step.
  void select_pair(double length, long cost) {
    if (trial_) {
      trial_ = false;
      if (cost < cost_before_) {
        trials_.succeeded();
      } else {
        switch_to(pair_before_, pair_before_ > pair_ ? std::min(length, step_at_end_) : length);
        trials_.failed();
        return;
      }
    }
    const bool one_step = cost == embedded_pairs[pair_].stages;
    if (pair_ < top_ && cost > embedded_pairs[pair_ + 1].stages) {
      start_trial(pair_ + 1, step_at_end_, cost);
    } else if (one_step && pair_ > 0 && trials_.due()) {
      start_trial(pair_ - 1, length, cost);
    }
  }

  void start_trial(int pair, double step, long cost) {
    trial_ = true;
    pair_before_ = pair_;
    cost_before_ = cost;
    switch_to(pair, step);
  }

  void switch_to(int pair, double step) {
    pair_ = pair;
    use(pair, step);
  }

  std::array<sundials::StepController, embedded_pairs.size()> controllers_;
  int top_, pair_;
  double length_ = 0;  // s, of the last communication step
  long attempts_before_ = 0;
  bool trial_ = false;  // of another pair, in the last communication step
  int pair_before_ = 0;
  long cost_before_ = 0;  // evaluations
  Backoff trials_{2, most_steps_between_trials};
};

}  // namespace

std::unique_ptr<Integrator> make_erk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Erk>(system, options);
}

}  // namespace gelenk
