// SPDX-License-Identifier: BSD-3-Clause
// Assembly: start values that satisfy the loops, as near as possible to what the user wants.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// InitialGuess for one list of coordinates and speeds, in the mechanism's signs: the tree's, or the cut joints'.
// Flags and weights go by speed: a quaternion is fixed as a whole.
struct InitialGuess {
  std::vector<double> q, v;
  std::vector<bool> q_fixed, v_fixed;      // keep exactly
  std::vector<double> q_weight, v_weight;  // of the squared distance to be made small; 0: no wish
  std::vector<bool> q_given;               // asked for by the user; the others only have to stand somewhere
  std::vector<bool> turns;                 // an angle, which means the same a turn further
};

struct Assembled {
  std::vector<double> q, v;     // of the tree
  std::vector<double> equal_q;  // another position of the tree that is as near to the wishes; empty: none is known
  double moved = 0;             // largest change of a coordinate that was given but not fixed, cut joints' included
  int tries = 1;                // starts needed until the loops closed
  double gap = 0;               // m or rad: the largest left where positions are held, of lengths near 1
};

// A fixed coordinate or speed, or the three turns of a quaternion: places in the lists of InitialGuess.
struct FixedValue {
  bool cut = false;  // in the cut joints' lists
  int first = 0, count = 1;
  int q = -1;  // its (first) coordinate; -1: a speed
};

// Fixed values that cannot be met together.
struct Conflict {
  std::vector<FixedValue> values;  // without any one of them the rest of them can be met; empty: none is to blame
  int freed = -1;                  // of values: if it were a guess all others could be met; -1: there is none
  double nearest = 0;              // what it would be then
};

// Which joint gapes, and how far, when no start closed the loops.
class CannotAssemble : public std::runtime_error {
 public:
  CannotAssemble(double gap, double turn, int cut, std::vector<double> q, Conflict conflict)
      : std::runtime_error("the loops cannot be closed"),
        gap(gap),
        turn(turn),
        cut(cut),
        q(std::move(q)),
        conflict(std::move(conflict)) {}
  double gap, turn;       // m, rad: where it gapes; of speeds the rate that is left [m/s, rad/s], and 0
  int cut;                // or, counted on behind the cuts, coordinate row; -1: positions fit, the fixed speeds do not
  std::vector<double> q;  // where the gap is smallest
  Conflict conflict;
};

// Smallest weighted change of the wishes, fixed ones kept, damped and step-limited (Levenberg-Marquardt to close the
// loops, Gauss-Newton along them to come near; Nocedal & Wright, ch. 10 and 18).
// Throws CannotAssemble with the smallest gap reached for positions, or what remains of a speed.
Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts);

}  // namespace gelenk
