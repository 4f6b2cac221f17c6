// SPDX-License-Identifier: BSD-3-Clause
// What a locator asks of equations that change their form (a stop begins or ends to push). Between events they keep to
// a mode, in which they are smooth beyond its end, too: so that a step may go too far, and be made again.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace gelenk {

class EventSource {
 public:
  virtual ~EventSource() = default;

  // Functions of y whose sign is the mode: at their zeros equations change. g, gdot (per s): their values and rates; a
  // rate that is not known is no number.
  virtual int indicators() const { return 0; }
  virtual void indicator_values(const double* /*y*/, double* /*g*/, double* /*gdot*/) {}
  // From now on, after t, the equations keep to the mode in which these indicators are positive; null: to that of each
  // state again.
  virtual void hold_mode(double /*t*/, const bool* /*positive*/) {}
  // The earliest time after that t at which they have been asked for outside the mode held; infinite: never.
  virtual double left_mode() const { return INFINITY; }

  // At t, an indicator has changed its sign: to positive or not. Once for each that does so at the same time.
  virtual void found_event(double /*t*/, int /*indicator*/, bool /*positive*/) {}
  // Empty, or why no more can be taken on in this communication step.
  virtual std::string too_many_events() const { return {}; }
};

// The indicators at y, and which of them are positive: at zero, those that do not fall.
inline void read_mode(EventSource& source, const double* y, std::vector<double>& g, std::vector<double>& gdot,
                      bool* positive) {
  source.indicator_values(y, g.data(), gdot.data());
  for (std::size_t i = 0; i < g.size(); ++i) positive[i] = g[i] > 0 || (g[i] == 0 && gdot[i] >= 0);
}

// While it lives the equations keep to a mode.
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
