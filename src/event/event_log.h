// SPDX-License-Identifier: BSD-3-Clause
// The events of a run: counted, those of the last communication step with their times.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "util/archive.h"

namespace gelenk {

struct Event {
  static constexpr int singular_position = -1;

  double time = 0;       // s
  int indicator = 0;     // that has changed its sign; or singular_position
  bool positive = true;  // to positive
};

struct EventReport {
  double time;       // s
  std::string text;  // "A.phi meets the stop at its upper bound"
  bool is_doubtful;  // of what follows: a singular position
};

class EventLog {
 public:
  // texts, by indicator: what happens where it becomes negative, and where it becomes positive. most: events in a
  // communication step, before it is given up.
  void describe(std::vector<std::array<std::string, 2>> texts, long most);

  // A communication step begins at t.
  void begin(double t);
  // So does a part of it, or all; it is taken back.
  void begin_part();
  void undo_part();
  void add(const Event& event);

  // Of the last part, in order; if there are very many, the first.
  const std::vector<Event>& events() const { return events_; }
  EventReport report(const Event& event) const;
  long count() const { return before_ + in_step_; }
  // Empty, or that there are too many in this communication step, which they are.
  std::string too_many() const;
  // Events listed are none of it.
  void serialize(Archive& archive);

 private:
  std::vector<std::array<std::string, 2>> texts_;
  std::vector<Event> events_;
  long most_ = 0;
  long before_ = 0, in_step_ = 0;
  long before_part_ = 0;  // of in_step_
  double start_ = 0;      // s, of the communication step
  Event last_{};

  std::string_view text(const Event& event) const;
};

}  // namespace gelenk
