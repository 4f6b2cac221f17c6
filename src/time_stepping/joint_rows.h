// SPDX-License-Identifier: BSD-3-Clause
// Dry friction, limits, one-way clutches and latches of joints in a step of TimeStepper: a row of velocities for each
// friction, each engaged latch and each bound that may be reached, and the impulses that their laws permit.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "complementarity/cone.h"
#include "dynamics/switching_forces.h"
#include "time_stepping/load_iteration.h"

namespace gelenk {

class JointRows {
 public:
  // nv: number of velocities.
  JointRows(SwitchingForces& switching_forces, int nv);

  struct Row {
    int lock = 0;
    int side = 0;  // of a limit; 0: friction or a latch
    double depth = 0;
    bool is_of_speed = false;  // of a one-way clutch, which bounds no position
    bool is_latch = false;
    int slides = 0;           // friction in motion, in this direction
    bool turns_back = false;  // it moves in the other direction at the end of the step
    DirectedLimit at_rest{}, sliding{};

    // Of a latch that engages in motion: how far the first half of the step has led beyond a limit, below 0 for a
    // lower.
    double passed = 0;
    bool is_friction() const { return side == 0 && !is_latch; }
  };
  // What a step of length h begins with: velocities, accelerations without impulses, forces of the last step by lock.
  struct Start {
    double h = 0;
    const double* v = nullptr;
    const double* vdot = nullptr;
    const std::vector<LockForces>& last;
  };

  std::size_t count() const { return rows_.size(); }
  bool any_of_speed() const { return std::ranges::any_of(rows_, &Row::is_of_speed); }
  const Row& operator[](std::size_t i) const { return rows_[i]; }
  void reserve(std::size_t rows) { rows_.reserve(rows); }
  void clear() {
    rows_.clear();
    are_undefined_ = false;
  }
  // Whether a law gave no number.
  bool are_undefined() const { return are_undefined_; }
  // Add rows, and their cones.
  void add(const Start& at, ContactRows& rows, std::vector<Cone>& cones);
  // Of limits that the velocities v1 at the end of the step lead beyond, although those at its start did not reach
  // them, as where an impact drives a joint to its limit: without impulses, the position ends at the limit, with the
  // speed with which the next step strikes it.
  void add_passed_limits(double h, const double* v1, ContactRows& rows, std::vector<Cone>& cones);

  // Friction of what slides, at the mean velocities vm of the last solution, with v1 at its end and the impulses x;
  // returns whether it has changed. cones: of these rows.
  bool set_sliding_friction(double h, const double* v1, const double* vm, const double* x, std::span<Cone> cones);
  // Whether the friction of any of them depends on loads.
  bool have_loads() const;
  // The limits of friction as they are set, and their kinds; with the loads of the last
  // solve(), at the mean velocities vm; and the indices of those that the impulses x have reached.
  void read_limits(std::vector<double>& out, std::vector<LoadIteration::Limit>& kinds) const;
  void find_limits(const double* vm, std::vector<double>& out) const;
  void set_limits(double h, const double* limits, std::span<Cone> cones);
  void add_reached_limits(const double* x, std::span<const Cone> cones, std::vector<int>& out) const;
  // Joints at rest that a correction of positions does not move; latches: those of one-way clutches, too.
  enum class Hold { all, latches, none };
  // Whether what is at rest may keep its joint where it is: friction not beyond a limit of the same joint, which it has
  // passed at the end of a step that ends with these speeds, by row of all.
  bool may_hold(const Row& joint, Hold hold, double h, std::span<const Cone> cones, const double* speeds) const;
  // Whether anything that slides is at rest with these velocities.
  bool any_stops(const double* v1) const;
  // By row: found <- 1 for those of latches whose joints move by more than solutions with this residual leave: they
  // have been engaged since the last step, which would have ended the motion. Returns whether there are any.
  bool find_engaged(const double* v, double residual, char* found) const;

  // out: by lock, the mean forces over the step with the impulses x, and the modes at its end, with velocities v1.
  void remember(double h, const double* v1, const double* x, std::span<const Cone> cones, std::vector<LockForces>& out);
  // The engaged latch of which the impulses have left the largest speed in the last step, as where a prescribed motion
  // moves its joint: closing loops afterwards changes speeds by errors of the step alone. lock: -1 without a latch.
  struct Moving {
    int lock = -1;
    double speed = 0;
  };
  const Moving& moving_latch() const { return moving_latch_; }

 private:
  void add_latch(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones);
  void add_friction(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones);
  void add_limits(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones);
  static bool stops_before(const Row& row, int motion);
  static void set_friction_of(const Row& row, double h, Cone& cone);
  void look_for_numbers(const Row& row);

  void share(std::vector<LockForces>& out) const;

  SwitchingForces& switching_;
  std::vector<int> beside_;  // by lock: another one of the same coordinate, that of a one-way clutch; -1: there is none
  std::vector<Row> rows_;
  bool are_undefined_ = false;
  Moving moving_latch_;
};

}  // namespace gelenk
