// SPDX-License-Identifier: BSD-3-Clause
// The steps with impulses of `auto`: those of `moreau-jean` (contact/time_stepper.h), of a length that is stable for
// the stiffness of the scene and keeps an accuracy, and with an estimate of their error.
//
// They are made in pairs of equal length s, whose local errors are estimated from what is known anyway: where
// velocities are smooth, the error of the positions is s^3/12 q''' for each step; where they jump by dv, it is of the
// order of s dv, since the time of the jump is not located. With the velocities v0, v1, v2 before, between and after
// the steps of a pair, s/6 |v2 - 2 v1 + v0| is the first one, and within the order of the second one. The local error
// s^3/24 v''' of the velocities follows from the accelerations by all but impulses in the middle of the last three
// steps. A pair whose error exceeds the accuracy is repeated with shorter steps. Lengths are solver.step halved a
// number of times, and grow only after several pairs: these steps preserve energy as long as their length does not
// change.
//
// A second run makes a step of 2 s for each pair. Its distance from the first one estimates the error of the positions
// (step halving): it is about that of the first run where velocities jump (order 1), and three times as much where they
// are smooth (order 2). Since the second run obeys the same equations, errors grow, decay and cancel in the estimate as
// they do in the run. If the estimate grows by more than its share of a time, the longest steps are halved, up to a
// number of times; not where it has become so large that it cannot be kept: piles of bodies are chaotic.
#pragma once

#include <vector>

#include "integrator/integrator.h"

namespace gelenk {

// The accuracy that these steps keep for a tolerance: the largest estimated error of a pair of steps, in positions
// [rad, natural units of length] and, relative to at least 1, in velocities; ten times as much is the share of a
// hundred steps of solver.step in the error of the run. The cost of an impact, whose time is not located, grows with
// the inverse of the accuracy; it is tenfold for a hundredth of the tolerance.
double accuracy_of_steps(double tolerance);

class ControlledSteps final : public Integrator {
 public:
  // always: these steps are all that the run makes.
  ControlledSteps(Equations& system, const IntegratorOptions& options, bool always);

  void restart(double t, const double* y) override;
  void inputs_changed() override;
  double advance(double end, double* y) override;
  double advance_some(double end, double* y, long max_steps) override;
  void begin() override { shortest_ = 0; }
  void serialize(Archive& archive) override;
  SteppedTime stepped_time() const override;

  // Call where steps begin, after restart(): for this reason.
  void begin(SchemeChange::Cause cause);
  // Call where they end.
  void end();
  // Pairs of steps in which contacts have changed.
  long changes() const { return changes_; }

 private:
  // What steps depend on, beside states.
  struct Memory {
    int halvings = 0;                          // of solver.step, for the next pair
    int halvings_for_share = 0;                // the fewest, by the estimate for the run
    int calm = 0;                              // pairs since the last one that was not far more accurate than necessary
    double frequency = 0;                      // the highest one of the scene [rad/s]
    int until_check = 0;                       // pairs before it is determined again
    double last_step = 0;                      // s; 0: there is none
    bool is_second_apart = false;              // otherwise the second run continues from the first
    double error = 0, error_before = 0;        // the largest one, and where the second run began
    double reviewed = 0, error_reviewed = 0;   // time [s] and error at the last review
    double rate_reviewed = 0;                  // by which velocities of the runs differed then
    double first = 0, since = 0, elapsed = 0;  // s: start of all steps, of the present ones; sum of those before
    double until = 0;                          // s: end of the last ones
    int parts = 0;
    bool is_stepping = false;
    SchemeChange::Cause cause = SchemeChange::Cause::none;  // of the first ones
  };

  double accuracy() const;  // of the next pair
  void make_pair(double end);
  bool try_pair(double t, double h);
  double local_error(double s) const;
  double length_towards(double end);
  void shorten(double h, double excess, bool is_again);
  void lengthen(double error);
  void review();
  void begin_second();
  void step_second(double t, double h);

  Equations& system_;
  ImpulseEquations& impulses_;
  double step_, accuracy_;
  double shortest_ = 0;  // pair in the present communication step [s]; 0: not known
  bool always_, started_ = false;
  double t_ = 0;
  std::size_t nq_, nv_;
  std::vector<double> y_, start_, middle_;  // of the first run: at present, and before and within the last pair
  std::vector<double> second_;              // of the second run
  std::vector<double> last_;                // accelerations in the last step
  std::vector<double> f1_, f2_;             // in the steps of the present pair
  bool changed_ = false;                    // whether contacts have changed in it
  long changes_ = 0;
  Memory memory_;
};

}  // namespace gelenk
