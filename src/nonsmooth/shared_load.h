// SPDX-License-Identifier: BSD-3-Clause
// Loads that contacts with friction share with joints that are held. Where what a held joint exerts and a normal force
// have the same effect, rigid bodies permit any share of both; but the friction of the contact is in proportion to its
// share, and with it the motion.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dynamics/switching_forces.h"

namespace gelenk {

struct SharedLoads {
  struct Point {
    int contact = 0;                   // of the scene
    Eigen::Index normal = 0;           // its multipliers: of the normal force
    Eigen::Index first = 0, size = 0;  // and of the friction that holds; size 0: it slides, or has no friction
    double coefficient = 0;            // of the friction that holds
    bool slides = false;               // against friction
  };
  std::vector<Point> points;
  std::vector<int> locks;          // of held joints
  std::vector<DirectedLimit> may;  // by lock in `locks`: the largest forces along either direction; may be infinite

  Eigen::VectorXd x, held;  // the present multipliers and forces of `locks`
  // Multipliers that do not move what is kept at rest, in columns; what they do to what moves; and the forces of
  // `locks` that they cause.
  Eigen::MatrixXd directions, effects, joints;
  double largest_effect = 0;  // of a single multiplier
};

struct SharedLoad {
  int contact = 0;  // of the scene
  int lock = 0;

  bool operator==(const SharedLoad&) const = default;
};

// A share on which the motion depends: of a contact that slides, where another share is possible; or of one that
// sticks, where it would slide if the joint did not press on it.
std::optional<SharedLoad> find_shared_load(const SharedLoads& of);

// Multipliers without effect: those of zero columns each by itself, and combinations of the others.
Eigen::MatrixXd directions_without_effect(const Eigen::MatrixXd& G);

// What friction, limits and latches of a lock can exert at its present position.
DirectedLimit largest_holding_forces(const SwitchingForces& forces, int lock);

}  // namespace gelenk
