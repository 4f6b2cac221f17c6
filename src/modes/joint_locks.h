// SPDX-License-Identifier: BSD-3-Clause
// What friction and limits of joints contribute where modes are decided together with those of contacts between shapes:
// the coordinates that are struck or at rest, and what becomes of them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "modes/lock_modes.h"

namespace gelenk {

// Coordinates at rest that friction may hold or limits may stop, and what becomes of them.
struct LockProblem {
  struct Lock {
    int lock = 0;
    Eigen::VectorXd row;                // of the speed of its coordinate, by velocity
    double sticking = 0, slipping = 0;  // limits of friction
    int contact = 0;                    // 1, -1: with the upper, the lower bound
    bool triggered = false;             // what keeps it at rest has reached its limit
    double noticed = 0;                 // larger accelerations are no rounding; known before decisions
    // In the modes of the last accelerate(): the force that keeps it at rest, and what of it may be rounding.
    double holding = 0, slack = 0;
    // The answer. direction: of the motion that begins, or that friction is at its limit against; 0: inside the limits.
    bool leaves = false;
    int direction = 0;
  };
  std::vector<Lock> locks;
  // vdot with the locks as they have been answered, and the contacts in their present modes.
  std::function<void(double* vdot)> accelerate;
};

class JointLocks {
 public:
  // modes must outlive it.
  JointLocks(LockModes& modes, int nv);

  bool empty() const { return modes_.empty(); }
  LockModes::State state() const { return modes_.state(); }
  void set_state(const LockModes::State& state) {
    if (!empty()) modes_.set_state(state);
  }
  // Call where a step begins at (t, y). Returns whether the modes have to be determined.
  bool recall(double t, const double* y);
  // Whether the modes do not follow from what is remembered alone.
  bool are_doubtful(double t, const double* y);
  bool is_triggered() const;
  // Of the indicators of friction and limits g, those that say that something at rest gives way. Returns the number of
  // coordinates at rest.
  std::size_t find_yielding(double* g, std::vector<double*>& out) const;

  // Whether the last solve() needed forces that friction and limits cannot exert.
  bool exceed_limits() const {
    return !empty() && modes_.any_at_rest_ && modes_.exceed(forces_.holding_forces().values());
  }

  // --- impacts, at the position of `dynamics` ---
  struct Struck {
    int lock = 0;
    StruckContact is;
    bool approaches = false;
    Eigen::VectorXd row;  // of the speed of its coordinate, by velocity
  };
  // The limits that are touched, and what stops as well (find_returning); y: before the impact; before: the modes
  // before all that happens at this instant.
  std::vector<Struck> struck(const double* y, const std::vector<int>& returning, const LockModes::State& before) const;
  // Releases what is at rest, for the equations of an impact.
  void let_go();
  // Whether a rebound at this speed is lost in the rounding of the position, for this acceleration back.
  bool is_lost(const Struck& at, double speed, double acceleration) const;
  // After it, in the modes before it: records what has been struck. rebounds: by element of `struck`, speeds after it.
  // closed_series: number of series of impacts that have ended.
  void finish_impact(double t, const double* y, const std::vector<Struck>& struck, const Eigen::VectorXd& rebounds,
                     bool found, int closed_series);

  // --- decisions, at the position of `dynamics` ---
  // The modes in which what moves keeps moving and the rest is undecided; enters them with these released.
  void begin_decision(double t, const double* y);
  // The same with only what rests in the present modes undecided.
  void begin_check();
  // Makes those undecided that leave a bound so slowly that they would return within the rounding of their positions,
  // with the accelerations vdot; returns whether there are any, for which accelerations have changed.
  bool add_returning(const double* y, const double* vdot);
  LockProblem& problem() { return problem_; }
  // Decides on them where there are no contacts, with the accelerations vdot.
  void decide_alone(const double* vdot);
  // Enters the modes that the answers mean, for a while.
  void try_answers();
  // The forces in these modes, of the last solve() with the effect of contacts.
  void read_forces();
  // Returns to the modes before the decision and enters those that follow at t; returns whether they are others.
  bool end_decision(double t, Recording records);
  // Lets go what has given way, where rounding hides it.
  void force_away(double t) { modes_.force_away(t); }
  // Stops what rests, and what begins to move from there.
  void finish(double* y) { modes_.finish_change(y); }
  // What has been set in motion at this instant and comes to rest before that matters (LockModes).
  static constexpr int most_returns = LockModes::most_returns;
  std::vector<int> find_returning(double t, const double* y, const LockModes::State& before,
                                  std::vector<int>& stopped) {
    return modes_.find_returning(t, y, before, stopped);
  }
  void record_changes(double t, const LockModes::State& before) { modes_.record_changes(t, before); }

 private:
  void add(int lock);
  void find_noticed_accelerations();
  LockModes::State answered();

  LockModes& modes_;
  Branching& forces_;
  std::vector<Eigen::VectorXd> rows_;  // by lock
  LockProblem problem_;
  LockModes::State before_, next_;
};

}  // namespace gelenk
