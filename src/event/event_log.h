// SPDX-License-Identifier: BSD-3-Clause
// The events of a run: their number, and those of the last communication step with their times.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "util/archive.h"

namespace gelenk {

struct Event {
  static constexpr int singular_position = -1;

  double time = 0;            // s
  int indicator = 0;          // index of the indicator that changed sign, or singular_position
  bool positive = true;       // the new sign
  bool is_ambiguous = false;  // more than one outcome is consistent, or none
};

struct EventReport {
  double time;       // s
  std::string text;  // "A.phi meets the stop at its upper bound"
  bool is_doubtful;  // the motion afterwards is uncertain: a singular configuration was crossed, or modes are ambiguous
};

class EventLog {
 public:
  // texts: for each indicator, the event when it becomes negative and when it becomes positive. max_events: limit on
  // the number of events in a communication step.
  void describe(std::vector<std::array<std::string, 2>> texts, long max_events);

  // Begins a communication step at t [s].
  void begin(double t);
  // Begins a part of it, or all of it.
  void begin_part();
  // An event with the text and the time of another one is the same event. It counts towards max_events all the same, so
  // that modes cannot alternate forever at one time.
  void add(const Event& event);
  // Forgets the last events, beyond a number of all that was reached within this part.
  void forget_beyond(long count);

  // The events of the last part in chronological order; if there are very many, the first ones.
  const std::vector<Event>& events() const { return events_; }
  EventReport report(const Event& event) const;
  long count() const { return before_ + in_step_; }
  // An error message if there are too many events in this communication step; otherwise empty.
  std::string too_many() const;
  // The list of events is not saved.
  void serialize(Archive& archive);

 private:
  std::vector<std::array<std::string, 2>> texts_;
  std::vector<Event> events_;
  long max_events_ = 0;
  long before_ = 0, in_step_ = 0;
  long repeated_ = 0;     // events in this communication step that were the same as another one
  long before_part_ = 0;  // value of in_step_ at the start of the part
  double start_ = 0;      // s: start of the communication step
  Event last_{};          // of this communication step, if there is one

  std::string_view text(const Event& event) const;
};

}  // namespace gelenk
