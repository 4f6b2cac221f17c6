// SPDX-License-Identifier: BSD-3-Clause
// The inputs as functions of time. From the present time of the run, t0, to the end of the next step each is
//   u(t) = u0 + d1 (t - t0) + d2 (t - t0)^2 / 2! + ... + d5 (t - t0)^5 / 5!
// with the value and the derivatives that were set, in either order; a derivative that was not set is zero. After the
// step the value is the one reached, and the derivatives are zero.
//
// Derivatives of an input that prescribes a motion are estimated from its values (motion_samples.h) in steps for which
// its value but no derivative was set, and in those that follow until a derivative is set. If it is not set again, its
// value at the next communication point is the one set last, not the one reached.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "formulation/motion_samples.h"
#include "util/archive.h"

namespace gelenk {

// A value type: a copy contains all that a run needs.
class Inputs {
 public:
  static constexpr int highest_order = 5;

  // `count` inputs, all zero, at t = 0. has_clock: another signal follows them, the time.
  explicit Inputs(std::size_t count, bool has_clock = false);
  // Declares that input `i` prescribes a motion, and that the `derivatives` inputs that follow it, at most 2, are the
  // values of its first derivatives.
  void add_motion(int i, int derivatives);

  // Inputs, and the clock if there is one, at the time of the last go_to(); the reference remains valid.
  const std::vector<double>& now() const { return now_; }
  void go_to(double t) {
    if ((moving_ || has_clock()) && t != now_time_) evaluate(t);
  }

  std::size_t count() const { return reached_.size(); }
  std::size_t signals() const { return now_.size(); }  // the clock included
  bool has_clock() const { return signals() > count(); }
  bool moving() const { return moving_; }  // some derivative is not zero
  // u0, or d^order u / dt^order at t0.
  double value(int i) const { return at(i, 0); }
  // The value as it was set, or that to which derivatives that were set have led.
  double given(int i) const;
  double derivative(int i, int order) const { return at(i, order); }
  // du/dt or d2u/dt2 (order 1, 2) at t0 as read by outputs: of the future motion once a derivative or another value has
  // been set, before that of the motion that has led to t0.
  double rate(int i, int order) const { return rates_[static_cast<std::size_t>(i) * 2 + order - 1]; }
  // u or one of its derivatives at t.
  double derivative_at(int i, int order, double t) const;

  // Sets a value from t0 on; now() is then evaluated at t0.
  enum class Change { none, smooth, jump };
  // smooth: equal, within rounding, to the value that u has reached by its derivatives.
  Change set(int i, double value);
  // Whether an input differs from the value reached at t0. One that was set to another value and back has not jumped.
  bool jumped() const;
  void set_derivative(int i, int order, double value);  // order 1 to highest_order
  // Why this derivative cannot be set ("found ..., expected ..."); empty: it can.
  static std::string fault(int order, double value);

  // Starts the run at t [s]: the values set hold from there.
  void start(double t);
  // Call before each step: sets the motions again that have not been set since the last one. changed(i, Change) is
  // called for each.
  template <class Changed>
  void renew(Changed changed) {
    for (Motion& m : motions_) {
      m.by_values = is_known_by_values(m);
      for (int i = m.first; m.by_values && !m.interrupted && i <= m.last; ++i) {
        if (!flags_[i].value_set) changed(i, set(i, flags_[i].given));
      }
    }
  }
  // Ends a step at t [s].
  void finish(double t);
  // Ends a step early at t [s]: u continues from there.
  void interrupt(double t);

  // The values from which derivatives of input `i` are estimated; null: they are not.
  const MotionSamples* samples(int i) const;
  // A jump of input `i`, a motion, that its values have revealed, or that its derivatives, inputs too, do not explain.
  MotionSamples::Jump jump(int i) const;

  void serialize(Archive& archive);

  // Whether both are the same functions of time.
  friend bool operator==(const Inputs& a, const Inputs& b);

 private:
  static constexpr int orders = highest_order + 1;

  // A motion: its input, which may be followed by inputs that are its derivatives.
  struct Motion {
    int first = 0, last = 0;
    bool by_values = true;           // it is known by values only
    bool interrupted = false;        // its step has ended early, and no value has been set since
    bool sends_derivatives = false;  // some of the inputs after `first` have been set
    MotionSamples samples;           // of `last`
    double before = NAN;             // value of `first` at the start of the last step
    MotionSamples::Jump jump = {};   // of `first`, if it is not `last`
    bool has_jumped = false;         // once in the run
  };
  // Of an input that belongs to a motion.
  struct Flags {
    int motion = -1;                                 // -1: it belongs to none
    bool value_set = false, derivative_set = false;  // since the last step
    double given = 0;                                // the value set last
  };

  double at(int i, int order) const { return taylor_[static_cast<std::size_t>(i) * orders + order]; }
  double& at(int i, int order) { return taylor_[static_cast<std::size_t>(i) * orders + order]; }
  void evaluate(double t);
  void update_moving();
  void shift_origin(int i, double t);
  void update_rates(int i);
  void note_reached();
  Change set_value(int i, double value);
  Change set_motion(Motion& m, int i, double value);
  void note_derivative(int i, double value);
  void start_motions();
  bool has_own_derivatives(const Motion& m) const;
  bool estimate(Motion& m);
  void find_jump(Motion& m) const;
  void clear_derivatives(int i);
  bool is_known_by_values(const Motion& m) const;
  void commit_samples();
  void end_motions();

  std::vector<double> taylor_;   // u0, d1, ..., d5 of each input
  std::vector<double> reached_;  // at t0, before values were set
  std::vector<double> now_;
  std::vector<double> rates_;   // see rate(); two of each input
  std::vector<double> change_;  // bound on the change of each input in the last step; 0: constant
  double start_ = 0;            // t0, s
  double now_time_ = 0;         // s
  bool moving_ = false;
  bool changed_ = false;  // some change_ is not zero
  bool started_ = false;
  std::vector<Motion> motions_;
  std::vector<Flags> flags_;  // by input; empty if there are no motions
};

// The longest step to a present value of a motion of which derivatives are estimated [s]; 0: there is none.
double estimated_over(const Inputs& inputs);

}  // namespace gelenk
