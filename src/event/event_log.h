// SPDX-License-Identifier: BSD-3-Clause
// The events of a run: their number, and those of the last communication step with their times.
#pragma once

#include <algorithm>
#include <array>
#include <span>
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
  // The indicator of another impact, so near in time that the accuracy of the run does not say which comes first; -1:
  // there is none.
  int other = -1;

  bool is_uncertain() const { return is_ambiguous || other >= 0; }
  bool is_doubtful() const { return is_uncertain() || indicator == singular_position; }
};

// Where a run goes over to time steps with impulses, or returns to located events.
struct SchemeChange {
  // Why steps begin; `none`: they end.
  enum class Cause { none, not_located, closed_points, contact_events, refused, overlap };

  double time = 0;  // s
  Cause cause = Cause::none;
  double since = 0;  // s: where the steps that end have begun
  double error = 0;  // their estimated error [rad, natural units of length]
};

// A load that a contact with friction shares with a joint that is held: how is not determined, but the motion depends
// on it.
struct SharedLoadEvent {
  double time = 0;   // s: where it has been seen first
  int contact = -1;  // of the scene; -1: there is none
  int force = 0;     // of those with modes, of the joint

  bool is_same(const SharedLoadEvent& other) const { return contact == other.contact && force == other.force; }
};

struct EventReport {
  double time;       // s
  std::string text;  // "A.phi meets the stop at its upper bound"
  // The motion afterwards is uncertain: a singular configuration was crossed, modes are ambiguous, or steps with
  // impulses begin or end.
  bool is_doubtful;
};

// Why steps begin: the end of a sentence.
const char* text_of(SchemeChange::Cause cause);
// "2.1e-4 (m, rad)": an error in natural units, one of which is a length [m].
std::string error_text(double error, double length);

class EventLog {
 public:
  // texts: for each indicator, the event when it becomes negative and when it becomes positive. max_events: limit on
  // the number of events in a communication step. first_of_contacts: indicators from this one on are of contacts
  // between shapes.
  void describe(std::vector<std::array<std::string, 2>> texts, long max_events, int first_of_contacts);

  // Those of all kinds; those of contacts between shapes.
  struct Counts {
    long all = 0, contacts = 0;
  };
  // Begins a communication step at t [s].
  void begin(double t);
  // Begins a part of it, or all of it.
  void begin_part();
  // An event with the text and the time of another one is the same event. It counts towards max_events all the same, so
  // that modes cannot alternate forever at one time.
  void add(const Event& event);
  // Forgets the last events, beyond counts that were reached within this part.
  void forget_beyond(const Counts& counts);

  // A change of scheme, which counts as no event.
  void add(const SchemeChange& change);
  // What is shared at the end of a part; it is an event, of uncertain outcome, where that was not so before.
  void set_shared(const SharedLoadEvent& shared);
  // Those of the last part; and of the run so far, the first ones.
  std::span<const SharedLoadEvent> shared_loads() const { return std::span(shared_).subspan(first_shared_); }
  std::span<const SharedLoadEvent> all_shared_loads() const { return shared_; }
  long shared_count() const { return shared_count_; }
  // The events of the last part in chronological order; if there are very many, the first ones.
  const std::vector<Event>& events() const { return events_; }
  const std::vector<SchemeChange>& scheme_changes() const { return scheme_changes_; }
  EventReport report(const Event& event) const;
  // length: of a natural unit [m].
  static EventReport report(const SchemeChange& change, double length);
  Counts counts() const { return {before_.all + in_step_.all, before_.contacts + in_step_.contacts}; }
  long count() const { return counts().all; }
  // Whether at least half of the events of this communication step are of contacts between shapes.
  bool contacts_prevail() const { return 2 * in_step_.contacts >= in_step_.all; }
  // An error message if there are too many events in this communication step; otherwise empty.
  std::string too_many() const;
  // The first of the events of the run so far of which the outcome is uncertain, and their number.
  std::vector<EventReport> uncertain() const;
  long uncertain_count() const { return uncertain_count_ + std::ranges::count_if(events_, &Event::is_uncertain); }
  // Lists of events are not saved.
  void serialize(Archive& archive);

 private:
  std::vector<std::array<std::string, 2>> texts_;
  std::vector<Event> events_;
  std::vector<Event> uncertain_;  // before the last part
  long uncertain_count_ = 0;
  std::vector<SchemeChange> scheme_changes_;
  std::vector<SharedLoadEvent> shared_;
  std::size_t first_shared_ = 0;  // of the last part
  SharedLoadEvent last_shared_;
  long shared_count_ = 0;
  long max_events_ = 0;
  int first_of_contacts_ = 0;
  Counts before_, in_step_;
  long repeated_ = 0;   // events in this communication step that were the same as another one
  Counts before_part_;  // value of in_step_ at the start of the part
  double start_ = 0;    // s: start of the communication step
  Event last_{};        // of this communication step, if there is one

  std::string_view text(const Event& event) const;
};

}  // namespace gelenk
