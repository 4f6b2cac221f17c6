// SPDX-License-Identifier: BSD-3-Clause
// The modes of everything that has several, held from one event to the next: stops, friction and limits of joints,
// contacts of shapes. The mode of a stop follows from the state; the others are remembered, and change at events.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "event/event_log.h"
#include "event/event_source.h"
#include "event_driven/hidden_changes.h"
#include "event_driven/joint_outputs.h"
#include "event_driven/law_edge.h"
#include "event_driven/lock_modes.h"
#include "event_driven/state_resets.h"
#include "kinematics/force_modes.h"
#include "kinematics/placed_formulas.h"

namespace gelenk {

class ContactModes;
class ModeChanges;
struct Loads;
struct Mechanism;

class EventModes final : public EventSource {
  class KinkProbe;
  class HeldProbe;

 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    const Loads& loads;
    ModeEquations& equations;
    EventLog& log;
    bool locates_contacts = false;
  };
  explicit EventModes(const Context& context);
  ~EventModes() override;

  // Two indicators for each force with modes, then one for each branch of a law. A stop or limit: for its upper and its
  // lower bound, positive while it is in contact. Friction: of motion in the positive and in the negative direction,
  // positive during it. There follow those of the signs of loads of friction, and those of contacts.
  int indicators() const override { return smooth_indicators() + contact_indicators(); }
  int own_indicators() const { return switching_indicators() + kinks_.count(); }
  bool recall_mode(double t, double* y) override;
  void remembered_mode(bool* positive) const override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override { return mode_exit_time_; }
  void found_event(double t, int indicator, bool positive) override;
  void change_mode(double t, double* y) override;
  std::string refusal() const override;
  // Why the last accelerations are not determined; otherwise empty.
  std::string indeterminacy() const;

  // Records whether an evaluation at t with velocities v, at the position of `dynamics`, is outside the held mode.
  void watch(double t, const double* v) {
    if (held_ && t > held_from_ && t < mode_exit_time_) check(t, v);
  }
  // The same where `dynamics` is not at the position, in which there are no contacts; y = (q, v, ...).
  void watch_motion(double t, const double* y) {
    if (sides_.empty() || !held_ || t <= held_from_ || t >= mode_exit_time_) return;
    dynamics_.set_coordinates(y, y + nq_);
    if (is_in_other_mode(y + nq_)) leave_at(t);
  }
  // The same after the accelerations have been solved for: whether what is kept at rest, or closed, can no longer be,
  // or an expression is on another branch. An implicit method iterates on the state at t: its last iterate counts.
  void watch_forces(double t) {
    if (!held_ || t <= held_from_ || t > mode_exit_time_) return;
    const bool is_outside = kinks_.are_passed() || are_overloaded();
    if (is_outside && t < mode_exit_time_) {
      left_by_forces_ = {true, mode_exit_time_};
      mode_exit_time_ = t;
    } else if (!is_outside && t == mode_exit_time_ && left_by_forces_.has) {
      left_by_forces_.has = false;
      mode_exit_time_ = left_by_forces_.before;
    }
  }
  // Whether all forces with modes are held in modes in which nothing is at rest.
  bool is_in_motion() const {
    return !locks_.any_at_rest() && std::ranges::find(sides_, mode_of_state) == sides_.end();
  }
  double since_step_began(double t) const { return held_ ? t - held_from_ : 0; }

  // Determines the modes from the state alone.
  void start(double t, const double* y);
  // Friction, limits and contacts are without effect until start().
  void release();

  LockModes& locks() { return locks_; }
  const LockModes& locks() const { return locks_; }
  ContactModes& contacts() { return *contacts_; }
  ModeChanges& changes() { return *changes_; }
  // The modes of all forces with modes in which derivatives are taken at (t, y), the present state: those in which a
  // step would begin; empty: those of the state. boundary: see LockModes::treat(); edge: ContactModes::edge().
  struct Present {
    std::vector<int> sides{};
    int boundary = -1;
    ContactHold contacts{};
    LawEdge edge{};
  };
  Present present(double t, const double* y, FrictionTreatment friction);
  // What outputs show.
  JointOutputs& outputs() { return outputs_; }
  void serialize(Archive& archive);

 private:
  int switching_indicators() const { return 2 * static_cast<int>(sides_.size()); }
  int smooth_indicators() const override { return own_indicators() + forces_.loads().signed_count(); }
  int contact_indicators() const;
  bool has_breaks() const override { return has_breaks_; }
  void indicator_values(double t, const double* y, double* g, double* gdot) override;
  bool drift(double t, double* y, double dt) override;
  double next_break(double t) override;
  void begin_stretch(double from, double to) override { equations_.begin_stretch(from, to); }
  void pass_break() override;
  bool is_of_impact(int indicator) const override;
  bool rates(double t, const double* y, double* ydot) override;
  void normalize(double* y) const override { dynamics_.normalize(y); }
  double touch_within(double t0, const double* y0, double t1, const double* y1) override;
  void keep_directions_below(double speed) override;
  double longest_step(double t, const double* y, const SlowSliding& by) override;
  void leave_at(double t);
  void check(double t, const double* v);
  bool is_in_other_mode(const double* v);
  bool may_hide_changes() const;
  double hidden_change(double t0, const double* y0, double t1, const double* y1);
  bool is_outside();
  // Whether the force with this index is a latch; or any force.
  static constexpr int any_force = -1;
  bool is_latch(int force) const;
  bool are_overloaded() const;

  Dynamics& dynamics_;
  SwitchingForces& forces_;
  LawKinks& kinks_;
  const Loads& loads_;
  ModeEquations& equations_;
  // Of all expressions that act, of which tuning changes no name; and whether motions have breaks.
  bool reads_time_, has_breaks_;
  int nq_, nv_;
  EventLog& log_;
  std::vector<int> sides_, present_sides_;  // of the forces: held, and those of the present state
  std::vector<double> g_, gdot_;            // indicators
  std::vector<double> rates_;               // of drift()
  bool held_ = false;                       // a mode is held
  double held_from_ = 0;                    // s: start of the held mode
  double mode_exit_time_ = INFINITY;        // s: see EventSource
  struct LeftByForces {
    bool has = false;   // watch_forces() has found mode_exit_time_
    double before = 0;  // what it was before
  } left_by_forces_;
  LockModes locks_;
  StateResets resets_;
  JointOutputs outputs_;
  std::unique_ptr<ContactModes> contacts_;
  std::unique_ptr<ModeChanges> changes_;
  std::vector<char> held_positive_;            // by indicator, of the held mode
  std::vector<double> probed_, probed_rates_;  // by indicator: workspace
  std::unique_ptr<ModeProbe> kink_probe_, mode_probe_;
  std::unique_ptr<HiddenChanges> hidden_changes_;
  bool nothing_moves_ = false;  // at the ends of the step in which changes are searched for
};

// During its lifetime the modes are those in which a step at (t, y) would begin with the present inputs; reading
// outputs does not change the run.
class ModePreview {
 public:
  ModePreview(EventModes& modes, double t, const double* y);
  ~ModePreview();
  ModePreview(const ModePreview&) = delete;
  ModePreview& operator=(const ModePreview&) = delete;

 private:
  EventModes& modes_;
};

}  // namespace gelenk
