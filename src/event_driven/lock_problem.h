// SPDX-License-Identifier: BSD-3-Clause
// Coordinates at rest that friction may hold, and limits and one-way clutches stop: the question which remain so, and
// the answer where no contacts take part.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "dynamics/switching_forces.h"

namespace gelenk {

struct LockProblem {
  struct Lock {
    int lock = 0;
    Eigen::VectorXd row;               // of the speed of its coordinate, by velocity; for decisions with contacts
    DirectedLimit sticking, slipping;  // limits of friction
    int contact = 0;                   // 1, -1: with the upper, the lower bound
    bool triggered = false;            // what keeps it at rest has reached its limit
    bool has_load = false;             // its friction depends on loads
    double noticed = 0;                // larger accelerations are no rounding; known before decisions
    // In the modes of the last accelerate(): the force that keeps it at rest, and what of it may be rounding.
    double holding = 0, slack = 0;
    // The answer. direction: of the motion that begins, or that friction is at its limit against; 0: inside the limits.
    bool leaves = false;
    int direction = 0;

    // What bounds the force that keeps it at rest, with a part of this friction.
    double lower(const DirectedLimit& friction, double part) const;
    double upper(const DirectedLimit& friction, double part) const;
    // 1, -1: it remains at rest, but needs a larger, or a smaller, force than these; 0: it does not.
    int side_beyond(double least, double most) const;
  };
  std::vector<Lock> locks;
  // The answer: a bound (locks[i].lock, its side) beyond which constraint equations lead.
  struct Unstoppable {
    int lock = -1;  // -1: there is none
    int side = 0;
  } unstoppable;
  // vdot with the locks as they have been answered, and the contacts in their present modes.
  std::function<void(double* vdot)> accelerate;

  bool breaks_away() const;
};

// The box problem of accelerations: what can remain at rest does. vdot: the accelerations with all released, of the
// last solve().
void decide_on_joints(SwitchingForces& forces, const double* vdot, LockProblem& problem);

}  // namespace gelenk
