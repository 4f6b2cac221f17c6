// SPDX-License-Identifier: BSD-3-Clause
#include "event/event_log.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "util/text.h"

namespace gelenk {
namespace {

// Capacity of the list of a communication step, for islands without and with stops.
constexpr std::size_t capacity_without_stops = 8;
constexpr std::size_t capacity_with_stops = 256;
// Of changes of scheme, which follow each other after tens of steps.
constexpr std::size_t capacity_of_schemes = 32;
// Of uncertain events of a run; later ones follow from a motion that is uncertain already.
constexpr std::size_t capacity_of_uncertain = 5;

constexpr const char* ambiguous_remark =
    ", although friction and limits permit more than one motion from there, or none exactly";

}  // namespace

const char* text_of(SchemeChange::Cause cause) {
  switch (cause) {
    case SchemeChange::Cause::not_located:
      return "events are not located in this scene: of pairs of shapes without located contacts, or of very many";
    case SchemeChange::Cause::closed_points:
      return "very many points of contact are closed";
    case SchemeChange::Cause::contact_events:
      return "contacts change very often";
    case SchemeChange::Cause::refused:
      return "located events are refused while shapes touch";
    case SchemeChange::Cause::overlap:
      return "shapes overlap whose contact was not located";
    case SchemeChange::Cause::none:
      break;
  }
  return "";
}

std::string error_text(double error, double length) {
  if (length == 1) return text::rounded(error, 2) + " (m, rad)";
  return text::rounded(error * length, 2) + " m, " + text::rounded(error, 2) + " rad";
}

void EventLog::describe(std::vector<std::array<std::string, 2>> texts, long max_events, int first_of_contacts) {
  texts_ = std::move(texts);
  max_events_ = max_events;
  first_of_contacts_ = first_of_contacts;
  scheme_changes_.reserve(capacity_of_schemes);
  uncertain_.reserve(capacity_of_uncertain);
  shared_.reserve(capacity_of_uncertain);
  events_.reserve(texts_.empty() ? capacity_without_stops : capacity_with_stops);
}

std::string_view EventLog::text(const Event& event) const {
  if (event.indicator == Event::singular_position)
    return "passed a singular configuration, where the loops could continue on another branch";
  return texts_.at(static_cast<std::size_t>(event.indicator))[event.positive ? 1 : 0];
}

void EventLog::begin(double t) {
  before_ = counts();
  in_step_ = {};
  repeated_ = 0;
  start_ = t;
}

void EventLog::begin_part() {
  before_part_ = in_step_;
  for (const Event& event : events_) {
    if (!event.is_uncertain()) continue;
    ++uncertain_count_;
    if (uncertain_.size() < capacity_of_uncertain) uncertain_.push_back(event);  // steps allocate no memory
  }
  events_.clear();
  scheme_changes_.clear();
  first_shared_ = shared_.size();
}

void EventLog::forget_beyond(const Counts& counts) {
  const long in_part = std::max(0L, counts.all - before_.all - before_part_.all);
  in_step_.all = before_part_.all + in_part;
  in_step_.contacts = std::max(before_part_.contacts, counts.contacts - before_.contacts);
  events_.resize(std::min(events_.size(), static_cast<std::size_t>(in_part)));
}

void EventLog::serialize(Archive& archive) {
  archive.serialize(before_.all, before_.contacts, in_step_.all, in_step_.contacts, start_);
  if (in_step_.all > 0) {  // the step may continue
    archive.serialize(repeated_, last_.time, last_.positive);
    archive.serialize_in_range(last_.indicator, Event::singular_position, static_cast<int>(texts_.size()) - 1);
  }
  archive.serialize(shared_count_, last_shared_.time);
  archive.serialize_in_range(last_shared_.contact, -1, std::numeric_limits<int>::max());
  archive.serialize_in_range(last_shared_.force, 0, std::numeric_limits<int>::max());
  if (!archive.reading()) return;
  events_.clear();  // of steps that were made in vain
  begin_part();
}

void EventLog::add(const Event& event) {
  if (text(event).empty()) return;  // a change of a force within its contact
  // Points of one contact that change together.
  for (auto other = events_.rbegin(); other != events_.rend() && other->time == event.time; ++other) {
    if (text(*other) != text(event)) continue;
    other->is_ambiguous = other->is_ambiguous || event.is_ambiguous;
    other->other = std::max(other->other, event.other);
    ++repeated_;
    return;
  }
  ++in_step_.all;
  if (event.indicator >= first_of_contacts_) ++in_step_.contacts;
  last_ = event;
  if (events_.size() < events_.capacity()) events_.push_back(event);  // steps allocate no memory
}

void EventLog::set_shared(const SharedLoadEvent& shared) {
  const bool is_new = shared.contact >= 0 && !shared.is_same(last_shared_);
  last_shared_ = shared;
  if (!is_new) return;
  ++shared_count_;
  if (shared_.size() < shared_.capacity()) shared_.push_back(shared);  // steps allocate no memory
}

void EventLog::add(const SchemeChange& change) {
  if (scheme_changes_.size() < scheme_changes_.capacity()) scheme_changes_.push_back(change);
}

EventReport EventLog::report(const SchemeChange& change, double length) {
  if (change.cause != SchemeChange::Cause::none)
    return {change.time, std::string("time steps with impulses from here on, since ") + text_of(change.cause), true};
  return {change.time,
          "located events from here on; the time steps since t = " + text::rounded(change.since) +
              " s have an estimated error of " + error_text(change.error, length),
          true};
}

EventReport EventLog::report(const Event& event) const {
  std::string words(text(event));
  if (event.is_ambiguous) words += ambiguous_remark;
  if (event.other >= 0)
    words += " so close in time to \"" + std::string(texts_.at(static_cast<std::size_t>(event.other))[1]) +
             "\" that, within the tolerance, their order and the motion afterwards are uncertain";
  return {event.time, words, event.is_doubtful()};
}

std::vector<EventReport> EventLog::uncertain() const {
  std::vector<EventReport> out;
  for (const Event& event : uncertain_) out.push_back(report(event));
  for (const Event& event : events_) {
    if (event.is_uncertain() && out.size() < capacity_of_uncertain) out.push_back(report(event));
  }
  return out;
}

std::string EventLog::too_many() const {
  if (in_step_.all + repeated_ <= max_events_) return {};
  return "more than " + std::to_string(max_events_) + " events (solver.max_events) since t = " + text::rounded(start_) +
         " s, the last: " + std::string(text(last_));
}

}  // namespace gelenk
