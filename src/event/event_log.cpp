// SPDX-License-Identifier: BSD-3-Clause
#include "event/event_log.h"

#include <algorithm>
#include <utility>

#include "util/text.h"

namespace gelenk {
namespace {

// Capacity of the list of a communication step, for islands without and with stops.
constexpr std::size_t capacity_without_stops = 8;
constexpr std::size_t capacity_with_stops = 256;

constexpr const char* ambiguous_remark =
    ", although friction and limits permit more than one motion from there, or none exactly";

}  // namespace

void EventLog::describe(std::vector<std::array<std::string, 2>> texts, long max_events) {
  texts_ = std::move(texts);
  max_events_ = max_events;
  events_.reserve(texts_.empty() ? capacity_without_stops : capacity_with_stops);
}

std::string_view EventLog::text(const Event& event) const {
  if (event.indicator == Event::singular_position)
    return "passed a singular configuration, where the loops could continue on another branch";
  return texts_.at(static_cast<std::size_t>(event.indicator))[event.positive ? 1 : 0];
}

void EventLog::begin(double t) {
  before_ += in_step_;
  in_step_ = 0;
  repeated_ = 0;
  start_ = t;
}

void EventLog::begin_part() {
  before_part_ = in_step_;
  events_.clear();
}

void EventLog::forget_beyond(long count) {
  const long in_part = std::max(0L, count - before_ - before_part_);
  in_step_ = before_part_ + in_part;
  events_.resize(std::min(events_.size(), static_cast<std::size_t>(in_part)));
}

void EventLog::serialize(Archive& archive) {
  archive.serialize(before_, in_step_, start_);
  if (in_step_ > 0) {  // the step may go on
    archive.serialize(repeated_, last_.time, last_.positive);
    archive.serialize_in_range(last_.indicator, Event::singular_position, static_cast<int>(texts_.size()) - 1);
  }
  if (archive.reading()) begin_part();
}

void EventLog::add(const Event& event) {
  if (text(event).empty()) return;  // a change of a force within its contact
  // Points of one contact that change together.
  for (auto other = events_.rbegin(); other != events_.rend() && other->time == event.time; ++other) {
    if (text(*other) != text(event)) continue;
    other->is_ambiguous = other->is_ambiguous || event.is_ambiguous;
    ++repeated_;
    return;
  }
  ++in_step_;
  last_ = event;
  if (events_.size() < events_.capacity()) events_.push_back(event);  // steps allocate no memory
}

EventReport EventLog::report(const Event& event) const {
  const bool doubtful = event.is_ambiguous || event.indicator == Event::singular_position;
  return {event.time, std::string(text(event)) + (event.is_ambiguous ? ambiguous_remark : ""), doubtful};
}

std::string EventLog::too_many() const {
  if (in_step_ + repeated_ <= max_events_) return {};
  return "more than " + std::to_string(max_events_) + " events (solver.max_events) since t = " + text::rounded(start_) +
         " s, the last: " + std::string(text(last_));
}

}  // namespace gelenk
