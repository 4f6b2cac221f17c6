// SPDX-License-Identifier: BSD-3-Clause
// What friction and limits of joints contribute to a decision on modes, at the position of `dynamics`.
#pragma once

#include <algorithm>
#include <vector>

#include "event_driven/lock_modes.h"
#include "event_driven/lock_problem.h"

namespace gelenk {

class JointDecisions {
 public:
  // modes must outlive it.
  explicit JointDecisions(LockModes& modes) : modes_(modes), forces_(modes.forces_) {}

  // The modes in which what moves keeps moving and the rest is undecided; enters them with these released.
  void begin(double t, const double* y);
  // The same with only what rests in the present modes undecided.
  void begin_check();
  // Makes those undecided that leave a bound so slowly that they would return within the rounding of their positions,
  // with the accelerations vdot; returns whether there are any, for which accelerations have changed.
  bool add_returning(const double* y, const double* vdot);
  LockProblem& problem() { return problem_; }
  // Adds the rows of the problem, which decisions with contacts need.
  void add_rows();
  // Enters the modes that the answers mean, for a while.
  void try_answers();
  // The forces in these modes, of the last solve() with the effect of contacts.
  void read_forces();
  // Returns to the modes before the decision; those that follow.
  LockModes::State end();
  // Enters them at t; returns whether they are others.
  bool enter(double t, LockModes::State next, Recording records);

  // --- where limits depend on loads ---
  // The modes in which all that is undecided is at rest.
  LockModes::State all_at_rest(double t, const double* y);
  // Whether anything undecided may move or open although friction that depends on loads holds.
  bool any_without_load() const {
    const auto may_move = [](const LockProblem::Lock& at) { return at.contact != 0 || !at.has_load; };
    return std::ranges::any_of(problem_.locks, may_move);
  }
  // In the present modes, at (t, y).
  double largest_holding_force(double t, const double* y);
  // Friction that depends on loads can exert this force at rest, if any; 0: what it can.
  void hold_by_friction(double force) { holding_friction_ = force; }
  // Brings the loads of friction to (t, y), in the present modes.
  void find_loads(double t, const double* y) { modes_.find_holding_forces(t, y); }
  // The largest friction at rest, by lock in both directions.
  std::vector<double> limits() const;
  // Of decisions before the last one; of everything that was undecided in it.
  void forget_doubts() { modes_.doubtful_.clear(); }
  void doubt_all();

 private:
  void add(int lock);
  void keep_latched(int lock);
  void find_noticed_accelerations();
  void take_up(LockModes::State& next, const LockProblem::Lock& at);
  LockModes::State answered();

  LockModes& modes_;
  SwitchingForces& forces_;
  LockProblem problem_;
  double holding_friction_ = 0;  // see hold_by_friction()
  LockModes::State before_, next_;
};

}  // namespace gelenk
