// SPDX-License-Identifier: BSD-3-Clause
// The modes of contacts between events: which candidates are closed, and where friction holds. They do not follow from
// the state, so they are remembered from one event to the next; mode_changes.h says what becomes of them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "contact_geometry/contact_finder.h"
#include "event/event_log.h"
#include "event/event_source.h"
#include "event_driven/contact_equations.h"
#include "event_driven/contact_outputs.h"
#include "event_driven/friction_treatment.h"
#include "event_driven/hidden_contacts.h"
#include "event_driven/law_edge.h"
#include "event_driven/mode_equations.h"
#include "event_driven/sliding_steps.h"
#include "util/archive.h"

namespace gelenk {

class ContactModes {
 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    const Loads& loads;
    ModeEquations& equations;
    bool located = false;  // otherwise there are none: contacts change in steps with impulses
  };
  explicit ContactModes(const Context& context);

  // Whether shapes can touch.
  bool any() const { return contact_equations_.candidates().count() > 0; }
  // Five indicators for each candidate: positive while it is closed; while it slips, spins and rolls against friction;
  // and while it is closed within the ends of its features.
  static constexpr int per_candidate = ContactOutputs::per_candidate;
  static constexpr int closed_indicator = 0;
  int indicators() const { return per_candidate * contact_equations_.candidates().count(); }
  void indicator_values(double t, const double* y, double* g, double* gdot);
  // Those of closed contacts alone, with the forces of the last accelerations, vdot.
  void indicators_of_closed(const double* vdot, double* g, double* gdot);
  // Of the indicators g, those that say that a contact gives way in which something is kept at rest.
  void find_yielding(double* g, std::vector<double*>& out) const;
  void remembered_mode(bool* positive) const;
  // See EventSource.
  double touch_within(double t0, const double* y0, double t1, const double* y1) {
    return any() ? hidden_.find(t0, y0, t1, y1) : INFINITY;
  }

  // See EventSource.
  double longest_step(double t, const double* y, const EventSource::SlowSliding& by);

  // All are open, as at the start of a run.
  void start();
  // Brings directions and distances up to the state where a step begins; returns whether something touches that was not
  // located.
  bool update(const double* y);
  // After update(): the contact of which shapes have come to overlap although nothing was found to touch, by its first
  // candidate; -1: none.
  int overlapping() const { return overlapping_; }
  // Brings `dynamics` and the candidates to y.
  void go_to(const double* y);
  // Where a step begins, after changes of modes.
  void begin_step(const double* y);
  // Whether a candidate touches, as far as its gap says; after go_to().
  bool may_touch(int candidate) const;
  // Whether something penetrates beyond its mode at the present position of `dynamics`.
  bool any_penetrates();
  // Whether something that sticks has a relative velocity, as where the belt that it lies on has been started.
  bool any_slips(const double* y);
  // Speeds up to this are rest.
  double slow(const double* v) const;

  // What the closed ones do where derivatives are taken with friction treated in this way.
  ContactHold held(FrictionTreatment friction) const;
  // The contact of which the present mode ends at any change of the state (t, y) or the inputs.
  LawEdge edge(double t, const double* y);

  const CandidateMode& mode_of(int candidate) const {
    return contact_equations_.modes()[static_cast<std::size_t>(candidate)];
  }
  ContactEquations& equations() { return contact_equations_; }
  const ContactEquations& equations() const { return contact_equations_; }
  ContactOutputs& outputs() { return outputs_; }
  void serialize(Archive& archive);

 private:
  void find_penetration(double* g);
  LawEdge edge_of_closed(double rest);
  bool may_close(int candidate);
  void update_guards();

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  ModeEquations& equations_;
  ContactEquations contact_equations_;
  HiddenContacts hidden_;
  ContactOutputs outputs_;
  // Contacts of edges, whose features may be passed within a step: penetration of the whole shapes is an event, too.
  struct Guard {
    int contact = 0, candidate = 0;  // of the scene; its first one, of which the indicator shows it
    double allowed = INFINITY;       // m: penetration where the step began
    double least = INFINITY;         // m: since the start
  };
  std::vector<Guard> guards_;
  int overlapping_ = -1;
  SlidingSteps sliding_steps_;
  std::vector<double> vdot_;
  std::vector<CandidateMode> updated_;  // where a step begins
  ContactEquations::Rows updated_rows_;
};

}  // namespace gelenk
