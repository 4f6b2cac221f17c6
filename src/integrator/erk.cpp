// SPDX-License-Identifier: BSD-3-Clause
// Explicit Runge-Kutta with adaptive steps (ARKODE's ERKStep), projected after each accepted step. Of several tables, a
// ladder from few stages to many, the one is used that takes the run from one communication point to the next with the
// fewest evaluations: where those lie close, a cheap method's one step serves as well as a dear one's.
#include <arkode/arkode_erkstep.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "integrator/arkode_integrator.h"
#include "integrator/step_controller.h"

namespace gelenk {
namespace {

// The classical method (Kutta 1901), order 4. All that four stages can tell of the error is of order 3; the weights
// with which h^3 y''' / 6 comes out follow from the conditions of orders 1 to 3. A part of it is held to the whole
// tolerance, so that errors stay where those of the other tables do: four-bar and arm in steps of 1 ms, N-four-bars and
// a double pendulum in steps of 10 and 20 ms. The 3/8 rule and Kuntzmann's did no better.
ARKodeButcherTable classical() {
  constexpr double share = 0.04;
  double c[] = {0, 1. / 2, 1. / 2, 1};
  double A[] = {0, 0, 0, 0, 1. / 2, 0, 0, 0, 0, 1. / 2, 0, 0, 0, 0, 1, 0};
  double b[] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  const double third[] = {2. / 3, -2. / 3, -2. / 3, 2. / 3};
  double d[4];
  for (int i = 0; i < 4; ++i) d[i] = b[i] - share * third[i];
  return sundials::made(ARKodeButcherTable_Create(4, 4, 2, c, A, b, d));
}

struct Rung {
  ARKODE_ERKTableID table;  // ARKODE_ERK_NONE: the one above
  int stages;
  double share;  // of the tolerance, for the local error test
};

// Of ARKODE's tables of order 5 to 9 the last two gave the smallest error for the evaluations spent, on loops and trees
// (four-bar, slider-crank, Andrews' squeezer, double pendulum, heavy top, cart-pole): order 6 above, 8 below.
// The share is such that errors stay within some tens of times the tolerance (see ida.cpp; here 0.1 to 22 times). Below
// them: many small steps in place of few long ones add up, so each has to be the better.
constexpr std::array<Rung, 4> ladder = {{
    {ARKODE_ERK_NONE, 4, 1},
    {ARKODE_CASH_KARP_6_4_5, 6, 0.03},
    {ARKODE_VERNER_9_5_6, 9, 0.1},
    {ARKODE_VERNER_13_7_8, 13, 0.1},
}};
int top_rung(double tolerance) { return tolerance > 3e-7 ? 2 : 3; }

// Every twentieth step is rejected with it; with ARKODE's own 0.96, every fifth (scenes as above).
constexpr double safety = 0.9;

// Below this the error test meets rounding.
constexpr double least_tolerance = 1e-13;

// Of steps of a lower rung in one communication step: it has met something.
constexpr long most_attempts = 6;
constexpr int longest_wait = 256;  // communication steps between two trials of another rung

class Erk final : public ArkodeIntegrator {
 public:
  Erk(Equations& system, const IntegratorOptions& options)
      : ArkodeIntegrator(system), top_(top_rung(options.tolerance)), rung_(top_) {
    for (int i = 0; i <= top_; ++i) {
      own(ERKStepCreate(sundials::rhs, 0, y_.get(), context_),
          std::max(least_tolerance, ladder[i].share * options.tolerance));
      take_table(ladder[i].table);
      ARKodeSetSafetyFactor(memory_, safety);
      controllers_[i] = sundials::make_step_controller(context_);
      ARKodeSetAdaptController(memory_, controllers_[i].get());
    }
  }

  void warm_up(double end, double* y) override {
    const double start = t_;
    const std::vector<double> from(y, y + system_.size());
    for (int i = 0; i <= top_; ++i) {
      go(i, end - start);
      restart(start, from.data());
      advance_some(end, y, 1);
    }
  }

  void exchange(Record& record) override {
    record.within(rung_, 0, top_);
    use(rung_, 0);
    long since = attempts() - attempts_before_;
    ArkodeIntegrator::exchange(record);
    for (int i = 0; i <= top_; ++i) sundials::exchange(controllers_[i], record);
    record.exchange(since, length_, trial_, cost_before_);
    record.within(rung_before_, 0, top_);
    trials_.exchange(record);
    attempts_before_ = attempts() - since;
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

  void reinitialise(void* memory) override { ERKStepReInit(memory, sundials::rhs, t_, y_.get()); }

  double next_step(std::size_t stepper) const override {
    return sundials::next_step(controllers_[stepper], safety, growth(stepper));
  }

  void choose_stepper(double end) override {
    const double length = end - t_;
    const long steps = attempts() - attempts_before_;
    const bool alike = steps > 0 && std::abs(length - length_) < 1e-6 * length;
    if (alike) climb(length, steps * ladder[rung_].stages);
    length_ = length;
    attempts_before_ = attempts();
  }

  void reconsider_stepper() override {
    if (rung_ == top_ || attempts() - attempts_before_ < most_attempts) return;
    trial_ = false;
    length_ = 0;  // the next communication step is not like this one
    trials_.failed();
    go(top_, current_step());
    attempts_before_ = attempts();
  }

  // cost: evaluations of the last communication step.
  void climb(double length, long cost) {
    if (trial_) {
      trial_ = false;
      if (cost < cost_before_) {
        trials_.succeeded();
      } else {
        go(rung_before_, rung_before_ > rung_ ? std::min(length, step_at_end_) : length);
        trials_.failed();
        return;
      }
    }
    const bool one_step = cost == ladder[rung_].stages;
    if (rung_ < top_ && cost > ladder[rung_ + 1].stages) {
      attempt(rung_ + 1, step_at_end_, cost);
    } else if (one_step && rung_ > 0 && trials_.due()) {
      attempt(rung_ - 1, length, cost);
    }
  }

  void attempt(int rung, double step, long cost) {
    trial_ = true;
    rung_before_ = rung_;
    cost_before_ = cost;
    go(rung, step);
  }

  void go(int rung, double step) {
    rung_ = rung;
    use(rung, step);
  }

  std::array<sundials::StepController, ladder.size()> controllers_;
  int top_, rung_;
  double length_ = 0;  // s, of the last communication step
  long attempts_before_ = 0;
  bool trial_ = false;  // of a rung, since the last communication step
  int rung_before_ = 0;
  long cost_before_ = 0;  // evaluations
  Backoff trials_{2, longest_wait};
};

}  // namespace

std::unique_ptr<Integrator> make_erk(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Erk>(system, options);
}

}  // namespace gelenk
