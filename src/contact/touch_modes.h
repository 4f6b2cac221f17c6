// SPDX-License-Identifier: BSD-3-Clause
// The modes of contacts between events: which spots are closed, and where friction holds. They do not follow from the
// state, so they are remembered from one event to the next.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contact/touch_decision.h"
#include "contact/touch_equations.h"
#include "contact/touched_equations.h"
#include "event/event_log.h"
#include "event/event_source.h"
#include "util/archive.h"

namespace gelenk {

class TouchModes final : public EventSource, public ContactReadings {
 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    const Loads& loads;
    TouchedEquations& equations;
    EventLog& log;
    int first_indicator = 0;  // number of indicators in the log before those of the spots
  };
  explicit TouchModes(const Context& context);

  // Four indicators for each spot: positive while it is closed; and while it slips, spins and rolls against friction.
  static constexpr int per_spot = 1 + contact_groups;
  int indicators() const override { return per_spot * touch_.spots().count(); }
  void indicator_values(double t, const double* y, double* g, double* gdot) override;
  bool recall_mode(double t, double* y) override;
  void remembered_mode(bool* positive) const override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override { return mode_exit_time_; }
  void found_event(double t, int indicator, bool positive) override;
  void change_mode(double t, double* y) override;
  std::string refusal() const override { return refusal_; }

  // Determines the modes from the state alone when the next step begins.
  void start();
  // Call when inputs have jumped.
  void inputs_jumped() { jumped_ = true; }
  // Records whether an evaluation at t, at the present position of `dynamics`, is outside the held mode.
  void watch(double t) {
    if (held_ && t > held_from_ && t < mode_exit_time_) check(t);
  }

  TouchEquations& equations() { return touch_; }
  // Enters the modes in which a step at (t, y) would begin, without recording it.
  void preview(double t, const double* y);
  // Records what outputs show, after the accelerations have been solved for.
  void record_outputs();
  // The recorded forces by link (ContactRows::apply_forces).
  const Spatial::Force* wrenches() const { return wrenches_.data(); }
  Eigen::Vector3d force(int contact) const override { return sums_[static_cast<std::size_t>(contact)].force; }
  int mode(int contact) const override { return sums_[static_cast<std::size_t>(contact)].mode; }
  double gap(int contact) override;

  struct Counts {
    long impacts = 0, closed_series = 0, ambiguous = 0;
  };
  const Counts& counts() const { return counts_; }
  long closed_spots() const { return static_cast<long>(touch_.closed().size()); }
  // By spot: what event messages name. Bodies of the scene; -1: the ground.
  struct SpotName {
    int contact, tip_body, core_body;
  };
  std::vector<SpotName> names() const;
  // Of the indicators of a spot: what happens when it becomes negative, and positive.
  static std::array<std::array<std::string, 2>, per_spot> event_texts(const std::string& contact,
                                                                      const std::string& tip, const std::string& core);
  void begin_part() { before_ = touch_.modes(); }
  void undo_part() { touch_.set_modes(before_); }
  void serialize(Archive& archive);

 private:
  const SpotMode& mode_of(int spot) const { return touch_.modes()[static_cast<std::size_t>(spot)]; }
  double slow(const double* v) const;
  void go_to(const double* y);
  void check(double t);
  void indicators_of_closed(double* g, double* gdot);
  bool holds_by_others(double t, const double* y);
  bool update_modes(const double* y);
  bool is_consistent(double t, const double* y);
  void strike(double t, double* y);
  void end_series(const std::vector<int>& struck, ContactImpact& impact, const Eigen::VectorXd& approach);
  std::vector<int> lasting(double rest);
  void decide(double t, const double* y, bool logs);
  void enter(double t, std::vector<SpotMode> next, bool logs);
  void finish(double* y);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  TouchedEquations& equations_;
  EventLog& log_;
  int first_indicator_;
  TouchEquations touch_;
  ContactDecision decision_;
  std::vector<SpotMode> before_;
  std::vector<Trigger> triggered_;  // by spot
  bool started_ = true, jumped_ = false;
  bool held_ = false;
  double held_from_ = 0, mode_exit_time_ = INFINITY;  // s
  Counts counts_;
  std::string refusal_;
  std::vector<double> vdot_;
  struct Sum {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    int mode = 0;
  };
  std::vector<Sum> sums_;                 // by contact of the scene
  std::vector<Spatial::Force> wrenches_;  // by link
};

}  // namespace gelenk
