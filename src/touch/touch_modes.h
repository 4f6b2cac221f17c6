// SPDX-License-Identifier: BSD-3-Clause
// The modes of contacts between events: which spots are closed, and where friction holds. They do not follow from the
// state, so they are remembered from one event to the next. What friction and limits of joints do is decided together
// with them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "event/event_log.h"
#include "modes/event_modes.h"
#include "modes/joint_locks.h"
#include "touch/hidden_touches.h"
#include "touch/touch_decision.h"
#include "touch/touch_equations.h"
#include "touch/touch_outputs.h"
#include "touch/touched_equations.h"
#include "util/archive.h"

namespace gelenk {

class TouchModes final : public ConnectedModes {
 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    const Loads& loads;
    TouchedEquations& equations;
    EventLog& log;
    LockModes& locks;         // of the same mechanism
    int first_indicator = 0;  // number of indicators in the log before those of the spots
  };
  explicit TouchModes(const Context& context);

  // Five indicators for each spot: positive while it is closed; while it slips, spins and rolls against friction; and
  // while it is closed within the ends of its features.
  static constexpr int per_spot = TouchOutputs::per_spot;
  int indicators() const override { return per_spot * touch_.spots().count(); }
  void indicator_values(double t, const double* y, double* g, double* gdot) override;
  void redistribute(double t, const double* y, double* locks, double* own) override;
  bool are_forces_unique() const override { return !redistributed_ && touch_.are_unique(); }
  bool recall_mode(double t, double* y) override;
  double touch_within(double t0, const double* y0, double t1, const double* y1) override {
    return hidden_.find(t0, y0, t1, y1);
  }
  void remembered_mode(bool* positive) const override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override { return mode_exit_time_; }
  double since_step_began(double t) const { return held_ ? t - held_from_ : 0; }
  void found_event(double t, int indicator, bool positive) override;
  void change_mode(double t, double* y) override;
  std::string refusal() const override { return refusal_; }

  // Determines the modes from the state alone when the next step begins.
  void start();
  // Call when inputs have jumped.
  void inputs_jumped() { jumped_ = true; }
  // Records whether an evaluation at t, at the present position of `dynamics`, is outside the held mode; after the
  // accelerations have been solved for: whether contacts cannot exert the forces of the mode.
  void watch(double t, bool is_solved) {
    if (!held_ || t <= held_from_ || t >= mode_exit_time_) return;
    if (!is_solved) return check(t);
    if (!redistributed_ && touch_.are_overloaded()) mode_exit_time_ = t;
  }

  TouchEquations& equations() { return touch_; }
  // Enters the modes in which a step at (t, y) would begin, without recording it.
  void preview(double t, const double* y);
  TouchOutputs& outputs() { return outputs_; }
  // Records the contact forces of the last accelerations, at (t, y), with which all contacts are open from then on;
  // where forces are redundant, within the laws.
  void record_outputs(double t, const double* y);

  struct Counts {
    long impacts = 0, closed_series = 0, ambiguous = 0;
  };
  const Counts& counts() const { return counts_; }
  void serialize(Archive& archive);

 private:
  void keep_directions_below(double speed) override { touch_.keep_directions_below(speed); }
  const SpotMode& mode_of(int spot) const { return touch_.modes()[static_cast<std::size_t>(spot)]; }
  double slow(const double* v) const;
  void go_to(const double* y);
  void check(double t);
  void indicators_of_closed(double* g, double* gdot);
  void find_yielding(double* g, std::vector<double*>& out) const;
  bool holds_by_others(double t, const double* y);
  bool exceed_laws();
  void set_accelerations(double t, const double* y);
  bool may_touch(int spot) const;
  void find_penetration(double* g);
  bool update_modes(double t, const double* y);
  void update_guards(double t);
  void refuse_ends(double t);
  bool is_consistent(double t, const double* y);
  void determine(double t, double* y);
  void strike(double t, double* y, const std::vector<int>& returning, const LockModes::State& before);
  int end_series(const std::vector<JointLocks::Struck>& limits, const double* vdot, ContactImpact& impact);
  void record_impacts(double t, const double* y, const std::vector<int>& struck, const ContactImpact& impact,
                      bool found);
  std::vector<int> lasting(double rest);
  bool decide(double t, const double* y, Recording records);
  void find_modes(const double* y, bool logs, double t, std::vector<SpotMode>& next);
  void enter(std::vector<SpotMode> next, Recording records);
  void record_changes(double t, const std::vector<SpotMode>& before);
  void finish(double* y);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  TouchedEquations& equations_;
  EventLog& log_;
  int first_indicator_;
  TouchEquations touch_;
  JointLocks locks_;
  HiddenTouches hidden_;
  ContactDecision decision_;
  TouchOutputs outputs_;
  std::vector<Trigger> triggered_;  // by spot
  bool started_ = true, jumped_ = false;
  bool held_ = false;
  // Whether forces of the last indicators hold only as others that have the same effect: what those of an evaluation
  // are beyond their limits says nothing.
  bool redistributed_ = false;
  double held_from_ = 0, mode_exit_time_ = INFINITY;  // s
  // Contacts of edges, whose features may be passed within a step: penetration of the whole shapes is an event, too.
  struct Guard {
    int contact = 0, spot = 0;  // of the scene; its first one, of which the indicator shows it
    double allowed = INFINITY;  // m: penetration where the step began
    double least = INFINITY;    // m: since the start
  };
  std::vector<Guard> guards_;
  Counts counts_;
  std::string refusal_;
  std::vector<double> vdot_;
  std::vector<double> checked_, checked_rates_;  // indicators where inputs have jumped
  std::unique_ptr<bool[]> expected_;
  std::vector<SpotMode> updated_;  // where a step begins
  TouchEquations::Rows updated_rows_;
};

}  // namespace gelenk
