// SPDX-License-Identifier: BSD-3-Clause
// The modes of coordinates with dry friction or a limit: which rest, which slip in what direction, which are in contact
// with a bound. They do not follow from the state, so they are remembered from one event to the next.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dynamics/distributed_forces.h"
#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "linear/box_complementarity.h"
#include "modes/impact.h"
#include "util/archive.h"

namespace gelenk {

// The equations of motion as modes need them.
class ModeEquations {
 public:
  // vdot (nv) at (t, y) in the held modes, without effect on the run; `dynamics` is left there.
  virtual void accelerations_at(double t, const double* y, double* vdot) = 0;
  // Called when a remembered mode has changed.
  virtual void mode_changed() = 0;
  // Brings the inputs of `dynamics` to t; returns whether they change from there on.
  virtual bool bring_inputs(double t) = 0;

 protected:
  ~ModeEquations() = default;
};

// What dry friction does where derivatives are taken: what it does there; nothing moves; everything moves, and what is
// at rest moves against a constant friction; nothing.
enum class FrictionTreatment { present, locked, sliding, off };

// What a decision on modes records: a preview, nothing; one of several at the same instant, what is doubtful.
enum class Recording : char { nothing, doubts, all };

class LockModes {
 public:
  // sides: the held modes of all forces with modes; those of friction and limits are written here.
  LockModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log, std::vector<int>& sides);

  bool empty() const { return modes_.motions.empty(); }
  // Whether friction or a limit keeps anything at rest.
  bool any_at_rest() const { return any_at_rest_; }
  // Whether the force with this index is friction or a limit; and whether it keeps its mode at any v: of a
  // coordinate at rest, or so slow that rounding decides on its direction.
  bool owns(int force) const { return lock_of_[static_cast<std::size_t>(force)] >= 0; }
  bool keeps_mode(int force, const double* v) const;
  // Sets the speeds of coordinates at rest to exactly 0, which they are within rounding.
  void clear_rest(double* v) const {
    if (any_at_rest_) forces_.clear(v);
  }
  // Brings the forces that keep coordinates at rest to (t, y), and returns the accelerations; null: neither is needed.
  const double* accelerations(double t, const double* y);
  // Brings them up to the last solve() of `dynamics`, distributed so that limits are used the least where they are
  // redundant. By lock. Overwrites the multipliers of that solve().
  const std::vector<double>& distribute_holding_forces();
  // The event indicators of all forces at the present state of `dynamics`, with these forces.
  void indicators(const double* vdot, double* g, double* gdot) const;
  // Whether the last solve() needed forces that friction and contact cannot exert.
  bool are_overloaded() const {
    return any_at_rest_ && !forces_.is_redundant() && exceed(forces_.holding_forces().values());
  }

  struct State {
    std::vector<int> motions;   // by lock; 1, -1: friction opposes motion in this direction; 0: it keeps at rest
    std::vector<int> contacts;  // by lock; 1, -1: with the upper, the lower bound; 0: none
    // By lock: depth up to which a coordinate leaves a bound that it still touches; 0: it does not.
    std::vector<double> leaves_from;
    // The indicator of a limit beyond which its coordinate moves and no force can stop it; -1: none.
    int unstoppable = -1;
    bool rests(int lock) const { return motions[lock] == 0 || contacts[lock] != 0; }
    bool operator==(const State&) const = default;
  };
  // Sets the tolerance of the integration, below which displacements do not matter (natural units).
  void set_tolerance(double tolerance);
  // Determines the modes from the state alone.
  void start(double t, const double* y);
  // The same where velocities have jumped, after release(); what was at rest before and has not been moved but by
  // rounding is stopped, and remains at rest if friction holds it.
  void restart(double t, double* y, const State& before);
  // Call when inputs have jumped.
  void inputs_jumped() { jumped_ = true; }
  // Brings the modes up to date where a step begins at (t, y); returns whether velocities in y have changed, because
  // something has come to rest.
  bool recall(double t, double* y);
  // Enters the modes that a step at (t, y) would begin in, without recording it.
  void preview(double t, const double* y);
  // Friction and limits are without effect until start().
  void release();

  // Records that an indicator has changed its sign; returns whether it is one of a remembered mode.
  bool found_event(int indicator);
  // Enters the modes that follow from the events found; impacts and sticking change the velocities in y.
  void change(double t, double* y) { change_any(t, y); }

  const State& state() const { return modes_; }
  struct Counts {
    long impacts = 0;        // of coordinates on their bounds
    long closed_series = 0;  // series of impacts that have ended in contact
    long ambiguous = 0;      // decisions with more than one consistent outcome, or none
  };
  const Counts& counts() const { return counts_; }
  void set_state(const State& state);
  // Enters the modes in which friction is treated in this way. Returns the index of a force of which the present mode
  // ends at any change of the state (t, y) or the inputs; -1: there is none.
  int treat(FrictionTreatment friction, double t, const double* y);
  void serialize(Archive& archive);

 private:
  friend class JointLocks;  // decides together with contacts of shapes
  // Of what is let go and comes to rest again at the same instant.
  static constexpr int most_returns = 20;
  enum Trigger : char { nothing, by_friction, by_limit };

  int count() const { return static_cast<int>(modes_.motions.size()); }
  bool has_friction(int lock) const { return forces_.lock(lock).friction >= 0; }
  bool rests(int lock) const { return modes_.rests(lock); }
  bool is_slow(int lock, const double* v) const;
  bool is_slow(int lock, const double* v, double tolerance) const;
  int touched_side(int lock) const;
  void find_holding_forces(double t, const double* y);
  void distribute(std::vector<double>& holding) const;
  bool exceed(const std::vector<double>& holding) const;
  int on_boundary(double t, const double* y);
  int limit_indicator(int lock, int side) const { return 2 * forces_.lock(lock).limit + (side > 0 ? 0 : 1); }
  double leaving_depth(int lock) const;
  void find_events_at_start(double t, const double* y);
  void find_reached_bounds(int lock, const double* v);
  void hold();
  bool is_doubtful(double t, const double* y, bool jumped);
  void record_doubtful(double t, bool logs);
  bool update(double t, const double* y, bool jumped, Recording records);
  bool settle(double t, const double* y, bool breaks_away, Recording records);
  void decide_at(State& next, const std::vector<int>& undecided, bool breaks_away, double t, const double* y);
  void decide_with_loads(State& next, const std::vector<int>& undecided, bool breaks_away, double t, const double* y);
  void decide(State& next, const std::vector<int>& undecided, bool breaks_away);
  void drop_rebounds(const double* v);
  bool change_any(double t, double* y);
  bool load_signs_changed();
  bool seize(double t, double* y);
  void force_away(double t);
  bool uses_limit_up(int lock) const;
  bool has_wrong_speed(int lock, const double* v) const;
  bool any_wrong_speed(const double* v) const;
  void stop(double* v);
  void enter(double t, State next, Recording records);
  void record_changes(double t, const State& before);
  void take_up(State& next, int lock, bool leaves, int direction);
  void finish_change(double* y);
  void strike(double t, double* y, const std::vector<int>& returning, const State& before);
  void record_impact(double t, int lock, int side, const Impact& impact);
  bool returns(int lock, const State& before, const double* v) const;
  std::vector<int> find_returning(double t, const double* y, const State& before, std::vector<int>& stopped);
  void close_returning(double t, double* y, const State& before);
  Impact solve_impact_without_series(const Eigen::MatrixXd& W, const double* v, const std::vector<int>& struck,
                                     std::vector<StruckContact>& contacts);
  int unstoppable_among(const std::vector<int>& locks, const BoxSolution& found, const HoldingBounds& bounds,
                        const Eigen::VectorXd& scale) const;
  bool ends_series(int lock, int side, double speed, double mobility, double resolution) const;

  ModeEquations& equations_;
  Dynamics& dynamics_;
  Branching& forces_;
  int nq_, nv_;
  EventLog& log_;
  std::vector<int>& sides_;
  std::vector<int> lock_of_;  // by force with modes; -1: none
  State modes_;
  std::vector<Trigger> triggered_;  // by lock: which indicator has changed its sign
  std::vector<double> holding_, vdot_;
  std::vector<double> load_indicators_;  // of the loads of meshes
  std::vector<char> load_signs_;         // where a step began last
  double resolution_ = 0;                // of displacements that do not matter
  bool any_friction_ = false;
  bool any_at_rest_ = false;
  bool jumped_ = false, started_ = false;  // since the last recall()
  Counts counts_;
  std::vector<int> doubtful_;  // locks of which the last decision is ambiguous
};

// During its lifetime the modes are those in which a step at (t, y) would begin with the present inputs; reading
// outputs does not change the run.
class ModePreview {
 public:
  ModePreview(LockModes& modes, double t, const double* y) : modes_(modes) {
    if (modes_.empty()) return;
    before_.emplace(modes_.state());
    modes_.preview(t, y);
  }
  ~ModePreview() {
    if (before_) modes_.set_state(*before_);
  }
  ModePreview(const ModePreview&) = delete;
  ModePreview& operator=(const ModePreview&) = delete;

 private:
  LockModes& modes_;
  std::optional<LockModes::State> before_;
};

}  // namespace gelenk
