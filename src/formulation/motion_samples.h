// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of an input that prescribes a motion, estimated from its values at communication points: those of the
// parabola through the present value and the last two, as far as these belong to a smooth motion. Errors of the
// parabola and of its first derivative are of third and second order in the step.
//
// The mean rates of the last two steps decide. If they have the same sign and similar magnitudes, the parabola is
// used; otherwise a straight line with the smaller rate, and none if the signs differ (the minmod limiter of Harten
// 1983). After a jump, this is the rate before it or after it, never that of the jump itself; near a turning point of
// a smooth motion it costs an error of second order in one or two steps. With one former value, no rate is known
// twice: the value is held.
#pragma once

#include "util/archive.h"

namespace gelenk {

class MotionSamples {
 public:
  struct Derivatives {
    double first = 0, second = 0;
  };
  struct Jump {
    double time = 0;  // s: of the first value after it
    double size = 0;  // 0: there is none
  };

  // Forgets all values.
  void clear() { *this = MotionSamples(); }
  // The value from t [s] on; until commit(), another call replaces it. Returns the derivatives at t.
  Derivatives add(double t, double value);
  // The same with a known derivative.
  void add(double t, double value, double rate);
  // The step that begins with the present value has been made.
  void commit();

  // If the present value belongs to the start of a motion whose start velocity was unknown: the time since then [s];
  // otherwise 0. What moves with it should continue as if that velocity had been known (Island::carry_along).
  double time_since_start() const { return has_present_ ? since_start_ : 0; }
  // Of the step that has led to the present value [s]; 0: it is not known.
  double span() const { return present_.span; }
  // A jump that the present value has revealed: positions before and after it have similar rates, or are constant.
  // Only the first one of a run.
  const Jump& jump() const { return jump_; }

  // Whether a jump of this size changes something visibly, which those of rounding do not.
  static bool is_visible(double size, double value);

  void serialize(Archive& archive);

 private:
  struct Sample {
    double time = 0, value = 0;
    double rate = 0;  // mean since the sample before it
    double span = 0;  // s: from that sample; 0: rate is the derivative at `time`
  };

  Derivatives rates_to_present();
  void find_jump();

  Sample last_, present_;
  double rate_before_ = 0;   // rate of the sample before last_
  Derivatives derivatives_;  // returned last
  double since_start_ = 0;   // see time_since_start()
  int count_ = 0;            // of committed samples, counted up to max_count; with a known rate at least 2
  bool has_present_ = false;
  bool warned_ = false;  // a jump has been found
  Jump jump_;
};

}  // namespace gelenk
