// SPDX-License-Identifier: BSD-3-Clause
// The modes of coordinates with dry friction or a limit: which rest, which slip in what direction, which are in contact
// with a bound. They do not follow from the state, so they are remembered from one event to the next.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/distributed_forces.h"
#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event_driven/friction_treatment.h"
#include "event_driven/mode_equations.h"
#include "util/archive.h"

namespace gelenk {

class LockModes {
 public:
  // sides: the held modes of all forces with modes; those of friction and limits are written here.
  LockModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log, std::vector<int>& sides);

  bool empty() const { return modes_.motions.empty(); }
  // Whether friction or a limit keeps anything at rest.
  bool any_at_rest() const { return any_at_rest_; }
  // Whether everything with modes is at rest.
  bool all_at_rest() const { return all_at_rest_; }
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
  void indicators(const double* vdot, double* g, double* gdot);
  // Whether the last solve() needed forces that friction and contact cannot exert.
  bool are_overloaded() const {
    return any_at_rest_ && !forces_.is_redundant() && exceed(forces_.holding_forces().values());
  }

  struct State {
    std::vector<int> motions;   // by lock; 1, -1: friction opposes motion in this direction; 0: it keeps at rest
    std::vector<int> contacts;  // by lock; 1, -1: with the upper, the lower bound; 0: none
    std::vector<int> latched;   // by lock; 1: its latch is engaged and holds it, with its joint; 0: it does not
    // By lock: depth up to which a coordinate leaves a bound that it still touches; 0: it does not.
    std::vector<double> leaves_from;
    // The indicator of a limit beyond which its coordinate moves and no force can stop it; -1: none.
    int unstoppable = -1;
    bool rests(int lock) const { return motions[lock] == 0 || contacts[lock] != 0 || latched[lock] != 0; }
    bool operator==(const State&) const = default;
  };
  // Sets the tolerance of the integration, below which displacements do not matter (natural units).
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }
  double tolerance() const { return tolerance_; }
  // Friction and limits are without effect until ModeChanges::start(); so are latches, if they are not kept.
  void release(bool keeps_latches = false);

  bool is_of_limit(int indicator) const {
    return owns(indicator / 2) &&
           forces_.lock(lock_of_[static_cast<std::size_t>(indicator / 2)]).limit == indicator / 2;
  }
  // Records that an indicator has changed its sign; returns whether it is one of a remembered mode.
  bool found_event(int indicator);

  const State& state() const { return modes_; }
  const ModeCounts& counts() const { return counts_; }
  void set_state(const State& state);
  // Keeps the present modes, and returns to those kept last.
  void keep_state() { kept_ = modes_; }
  void return_to_state();
  // Enters the modes in which friction is treated in this way. Returns the index of a force of which the present mode
  // ends at any change of the state (t, y) or the inputs; -1: there is none.
  int treat(FrictionTreatment friction, double t, const double* y);
  void serialize(Archive& archive);

 private:
  // What becomes of them.
  friend class JointChanges;
  friend class JointDecisions;
  friend class JointImpacts;
  friend class JointLatches;
  enum Trigger : char { nothing, by_friction, by_limit, by_latch };

  int count() const { return static_cast<int>(modes_.motions.size()); }
  bool has_friction(int lock) const { return forces_.lock(lock).friction >= 0; }
  bool rests(int lock) const { return modes_.rests(lock); }
  static std::size_t at_index(int i) { return static_cast<std::size_t>(i); }
  // Whether a latch holds the coordinate, so that its friction and limits have nothing to hold.
  bool is_latched(int lock) const { return any_latch_ && forces_.hold_coordinate(lock); }
  bool is_slow(int lock, const double* v) const;
  bool is_slow(int lock, const double* v, double tolerance) const;
  bool is_unmoved(int lock, const double* v) const;
  double resolution() const;  // of displacements that do not matter
  int touched_side(int lock) const;
  void find_holding_forces(double t, const double* y);
  void distribute(std::vector<double>& holding);
  void keep_indicators(const double* g, const double* gdot);
  bool exceed(const std::vector<double>& holding) const;
  int on_boundary(double t, const double* y);
  int boundary_in_motion(int lock, const double* v) const;
  int boundary_at_rest(int lock) const;
  int limit_indicator(int lock, int side) const { return 2 * forces_.lock(lock).limit + (side > 0 ? 0 : 1); }
  Eigen::VectorXd row(int lock) const;
  double leaving_depth_of(int lock) const;
  bool returns_to(int lock, int side, double resolution, double speed, double back) const;
  void hold();
  void enter(State next, Recording records);
  bool is_doubtful(double t, const double* y, bool jumped);
  bool has_wrong_speed(int lock, const double* v) const;
  bool any_wrong_speed(const double* v) const;
  void stop(double* v);

  ModeEquations& equations_;
  Dynamics& dynamics_;
  SwitchingForces& forces_;
  int nq_, nv_;
  EventLog& log_;
  std::vector<int>& sides_;
  std::vector<int> lock_of_;  // by force with modes; -1: none
  State modes_, kept_;
  std::vector<Trigger> triggered_;  // by lock: which indicator has changed its sign
  std::vector<double> holding_;
  std::vector<double> indicators_, indicator_rates_;  // of forces, as last found with accelerations
  std::vector<double> vdot_;
  DistributedForces distributed_;
  // Dynamics::solution() of holding_ and of indicators_; -1: of none.
  long distributed_at_ = -1, indicated_at_ = -1;
  std::vector<int> resting_;  // of distribute()
  double tolerance_ = 0;
  bool any_friction_ = false;
  bool any_latch_ = false;
  bool any_at_rest_ = false;
  bool all_at_rest_ = false;
  bool owns_all_ = false;  // all forces with modes are friction or limits
  ModeCounts counts_;
  std::vector<int> doubtful_;  // locks of which the last decision is ambiguous
};

}  // namespace gelenk
