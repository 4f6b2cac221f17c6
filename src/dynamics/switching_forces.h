// SPDX-License-Identifier: BSD-3-Clause
// The interface to forces along tree joints and cut joints that have modes (element/joint_forces/coordinate_force.h):
// stops, and friction and limits, which can keep their coordinate at rest ("lock" it).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "dynamics/contact_rows.h"
#include "dynamics/force_rounding.h"
#include "dynamics/holding_forces.h"
#include "dynamics/latches.h"
#include "dynamics/load_dependence.h"
#include "kinematics/force_modes.h"

namespace gelenk {

// The largest friction against motion in either direction, in the user's sign. They differ where gears have losses.
struct DirectedLimit {
  double positive = 0, negative = 0;
  bool vanishes = false;  // under any load: without friction, or an open clutch or brake

  DirectedLimit& operator+=(const DirectedLimit& other) {
    positive += other.positive;
    negative += other.negative;
    vanishes = vanishes && other.vanishes;
    return *this;
  }
  double against(int direction) const { return direction > 0 ? positive : negative; }
  double largest() const { return std::max(positive, negative); }
};

// What friction, a limit and a latch of a coordinate do: forces in the user's sign [N m, N], and modes as outputs show
// them.
struct LockForces {
  double friction = 0, limit = 0, latch = 0;
  int motion = 0, contact = 0;
  bool is_latched = false;
};

class SwitchingForces : public Latches, public ForceRounding {
 public:
  ~SwitchingForces() override = default;

  // --- all forces with modes ---
  virtual int count() const = 0;
  // The mode of each force at the current state; count() numbers.
  virtual void sides(int* sides) const = 0;
  // Event indicators at the current state, two per force, whose zeros are the changes of mode, and their rates.
  // Friction and limits are in their held modes. holding: by lock, the force that keeps it at rest. vdot: the
  // accelerations, or null.
  virtual void indicators(const std::vector<double>& holding, const double* vdot, double* g, double* gdot) const = 0;
  // Whether rates of indicators at the current state depend on vdot, of forces other than friction and limits.
  virtual bool needs_accelerations() const = 0;
  // Holds the forces in these modes (or mode_of_state, mode_released) in the equations and in
  // differentiate(); `sides` is read at each evaluation. null: they are in the modes of the state, and nothing is
  // locked.
  virtual void hold(const int* sides) = 0;
  virtual const int* held_modes() const = 0;  // as given to hold()
  // Inputs of the scene, at least up to the last one that a force with modes has; solve() sets those that they have.
  virtual std::span<double> inputs() = 0;

  // --- coordinates with friction or a limit, by lock: values have the user's signs ---
  struct Lock {
    int friction = -1, limit = -1;  // indices in all forces with modes, the first of friction; -1: it has none
    // Its part of the lock of a whole joint, which holds it, engaged, by a force of any size; -1: it has none. joint:
    // of the scene, of which all parts are engaged together; the events of the first are those of the lock.
    int latch = -1, latched_joint = -1;
    int latched_q = -1;  // of the coordinates of the mechanism; -1: the joint closes a loop
    bool is_first_of_latch = false;
    // The laws of its friction, which add up and share one mode: indices in all forces with modes.
    std::vector<int> frictions;
    double sign = 1;  // user's speed = sign times the mechanism's
    bool poisson = false;
    bool one_way = false;  // the limit bounds the speed: it is touched at any position
  };
  virtual int locks() const = 0;
  virtual const Lock& lock(int lock) const = 0;
  // See element/joint_forces/coordinate_force.h; 0 without friction.
  virtual DirectedLimit sticking_limit(int lock) const = 0;
  virtual DirectedLimit slipping_limit(int lock) const = 0;
  // The part of the friction of its coordinate that one of them exerts: at rest, where they exert it in proportion to
  // their limits, or in motion in this direction at the present speed.
  virtual double part_of_friction(int friction, int motion) const = 0;
  // The friction in motion at this speed, in the user's sign; 0 without friction.
  virtual DirectedLimit sliding_limit(int lock, double speed) const = 0;
  // Friction that depends on loads: its limits are those at the last solve().
  virtual LoadDependence& loads() = 0;
  // Contacts between shapes, which act by impulses.
  virtual ContactRows& contact_rows() = 0;
  // How far the coordinate is beyond its upper (side 1) or lower limit (side -1) at the current position, and how close
  // to it counts as contact [rad, m]; and the coefficient of restitution with which it is struck.
  struct Depth {
    double depth, tolerance, restitution = 0;
  };
  virtual Depth depth(int lock, int side) const = 0;
  virtual double speed(int lock, const double* v) const = 0;  // of its coordinate; or its acceleration, from vdot
  // The forces in the last solve() that keep coordinates at rest.
  virtual HoldingForces& holding_forces() = 0;
  // Whether some held coordinates would remain at rest without their holding forces.
  virtual bool is_redundant() const = 0;
  // Brings the loads of friction at rest to other holding forces, by lock, with the same effect as those of the last
  // solve(). Overwrites its multipliers.
  virtual void distribute_loads(const std::vector<double>& holding) = 0;
  // W: the accelerations of the coordinates of these locks (rows) per force along them (columns), all released but
  // latches of others, with the factors of the last solve(). scale: the accelerations to which its rounding is
  // relative. Allocates.
  virtual void compliance(const std::vector<int>& locks, Eigen::MatrixXd& W, Eigen::VectorXd& scale) = 0;
  // Adds to v the effect of impulses along these coordinates, all released, with the same factors.
  virtual void strike(const std::vector<int>& locks, const Eigen::VectorXd& impulses, double* v) = 0;
  // Sets the velocities of locked tree coordinates to 0.
  virtual void clear(double* v) = 0;
  // Changes v by the least amount in the mass metric that stops the locked coordinates, which are at rest within
  // rounding. Returns false if some are not stopped, since rounding does not explain how the motion would change.
  virtual bool stop(double* v) = 0;
};

// Whether something that slips may come to rest with the present inputs, so that the rate of its speed matters. Open
// brakes and clutches have no friction, and accelerations cost an evaluation.
inline bool any_can_stick(SwitchingForces& switching_forces) {
  if (!switching_forces.loads().empty()) return true;
  for (int i = 0; i < switching_forces.locks(); ++i) {
    if (switching_forces.lock(i).one_way || switching_forces.sticking_limit(i).largest() > 0 ||
        switching_forces.slipping_limit(i).largest() > 0)
      return true;
  }
  return false;
}

// by_force <- the parts of the laws of a lock of its friction (T), by force with modes.
template <class T>
void share_friction(const SwitchingForces& switching_forces, int lock, int motion, const T& friction, T* by_force) {
  const std::vector<int>& laws = switching_forces.lock(lock).frictions;
  for (const int law : laws)
    by_force[law] = laws.size() == 1 ? friction : T(switching_forces.part_of_friction(law, motion)) * friction;
}

// The forces of friction and limits at rest, by force with modes, from the holding forces x (T), by lock: a limit
// pushes, and what pulls is friction. sides: the held modes.
template <class T>
void share_holding_forces(const SwitchingForces& switching_forces, const int* sides, const T* x, T* by_force) {
  std::fill_n(by_force, switching_forces.count(), T(0));
  for (int i = 0; i < switching_forces.locks(); ++i) {
    const SwitchingForces::Lock& lock = switching_forces.lock(i);
    if (lock.latch >= 0 && sides[lock.latch] == 1) {
      by_force[lock.latch] = x[i];
      continue;
    }
    const int contact = lock.limit < 0 ? 0 : sides[lock.limit];
    const bool pushes = contact > 0 ? x[i] < T(0) : x[i] > T(0);
    if (contact != 0 && (pushes || lock.friction < 0)) {
      by_force[lock.limit] = x[i];
    } else if (lock.friction >= 0 && sides[lock.friction] == 0) {
      share_friction(switching_forces, i, 0, x[i], by_force);
    }
  }
}

}  // namespace gelenk
