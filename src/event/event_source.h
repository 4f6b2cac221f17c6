// SPDX-License-Identifier: BSD-3-Clause
// The interface of equations that change their form (a stop engages, friction sticks). Between events they remain in a
// mode, in which they are also smooth beyond its end, so that a step may go too far and be repeated.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace gelenk {

class EventSource {
 public:
  virtual ~EventSource() = default;

  // Event indicators: functions of t and y whose signs define the mode and at whose zeros the equations change. g, gdot
  // [1/s]: values and rates at (t, y); an unknown rate is NaN.
  virtual int indicators() const { return 0; }
  virtual void indicator_values(double /*t*/, const double* /*y*/, double* /*g*/, double* /*gdot*/) {}
  // Called where a step begins: brings the modes that the equations remember up to date if inputs have jumped, and
  // returns whether velocities in y have changed, because something has come to rest; and sets `positive` for their
  // indicators, of which the signs alone do not decide.
  virtual bool recall_mode(double /*t*/, double* /*y*/) { return false; }
  virtual void remembered_mode(bool* /*positive*/) const {}
  // After t [s] the equations are kept in the mode in which these indicators are positive; null: the mode follows from
  // each state again, as far as it is not remembered.
  virtual void hold_mode(double /*t*/, const bool* /*positive*/) {}
  // The earliest time after that t at which the equations were evaluated outside the held mode [s]; infinite: never.
  virtual double mode_exit_time() const { return INFINITY; }

  // How many indicators, the first ones, are smooth beyond a mode, so that modes that end and begin again before an
  // event within the same step are searched for. Those of contacts between shapes are not: false alarms would cut steps
  // again and again.
  virtual int smooth_indicators() const { return indicators(); }

  // The earliest time [s] within a step from (t0, y0), where it began, to (t1, y1), the state of the last
  // indicator_values(), at which a mode may have ended and begun again without a trace in the indicators at both ends;
  // infinite: none is known.
  virtual double touch_within(double /*t0*/, const double* /*y0*/, double /*t1*/, const double* /*y1*/) {
    return INFINITY;
  }

  // Times at which functions of time have a kink, known in advance: steps end there. The next one after t [s];
  // infinite: none.
  virtual bool has_breaks() const { return false; }
  virtual double next_break(double /*t*/) { return INFINITY; }
  // From one break to the next [s] functions of time are those in between, at both ends, too; NaN: at a break they are
  // those after it.
  virtual void begin_stretch(double /*from*/, double /*to*/) {}
  // Called where a step has ended at a break.
  virtual void pass_break() {}

  // Called when an indicator has changed its sign at t [s]; once for each indicator.
  virtual void found_event(double /*t*/, int /*indicator*/, bool /*positive*/) {}
  // Called after these, with the state at t from which the run continues: enters the mode that follows, and may change
  // the velocities.
  virtual void change_mode(double /*t*/, double* /*y*/) {}
  // Moves the state y from t by a time dt [s] of which the square does not matter, in the held mode. Returns false, and
  // does nothing, where states do not follow smoothly from the length of a step.
  virtual bool drift(double /*t*/, double* /*y*/, double /*dt*/) { return false; }
  // Whether velocities may jump where this indicator changes its sign: something strikes a limit or a body.
  virtual bool is_of_impact(int /*indicator*/) const { return false; }
  // ydot <- the rates at (t, y) in the held mode. Returns false, and does nothing, if they are not known.
  virtual bool rates(double /*t*/, const double* /*y*/, double* /*ydot*/) { return false; }
  // Normalizes the quaternions in y.
  virtual void normalize(double* /*y*/) const {}
  // Relative motions slower than this have no direction of their own: they keep the one in which they began [natural
  // units of speed]. The slower a motion is, the faster friction turns it, so that steps would amplify rounding at the
  // beginning and the end of motions.
  virtual void keep_directions_below(double /*speed*/) {}
  // How well a method follows the direction of friction on what slides slowly.
  struct SlowSliding {
    double followed_from = INFINITY;  // speed from which its control of errors follows it [natural units]
    double directed_from = 0;         // speed up to which motions keep their directions
    bool is_explicit = false;         // its steps are limited by stability
  };
  // Within this time [s] from (t, y), the state of the last indicator_values(), friction turns and slows down what
  // slides by so little that a method follows; infinite: there is nothing to follow.
  virtual double longest_step(double /*t*/, const double* /*y*/, const SlowSliding& /*by*/) { return INFINITY; }
  // Why the run cannot continue (too many events in this communication step, or no mode that is possible); otherwise
  // empty.
  virtual std::string refusal() const { return {}; }
};

// Whether an indicator with this value and rate counts as positive.
inline bool is_positive(double g, double gdot) { return g > 0 || (g == 0 && gdot >= 0); }

// Evaluates the indicators at (t, y) and determines which are positive; at zero, those with nonnegative rate.
inline void read_mode(EventSource& source, double t, const double* y, std::vector<double>& g, std::vector<double>& gdot,
                      bool* positive) {
  source.indicator_values(t, y, g.data(), gdot.data());
  for (std::size_t i = 0; i < g.size(); ++i) positive[i] = is_positive(g[i], gdot[i]);
}

// Holds a mode of the equations during its lifetime.
class HeldMode {
 public:
  HeldMode(EventSource& source, double t, const bool* positive) : source_(source) { source_.hold_mode(t, positive); }
  ~HeldMode() { source_.hold_mode(0, nullptr); }
  HeldMode(const HeldMode&) = delete;
  HeldMode& operator=(const HeldMode&) = delete;

 private:
  EventSource& source_;
};

}  // namespace gelenk
