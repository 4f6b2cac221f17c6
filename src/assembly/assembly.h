// SPDX-License-Identifier: BSD-3-Clause
// Assembly: finds start values that satisfy the loop equations and are as near as possible to the values given by the
// user.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// Initial guesses and fixed values for one list of coordinates and velocities, with the signs used inside the
// mechanism: those of the tree joints or those of the cut joints. Flags and weights are indexed by velocity; a
// quaternion is fixed as a whole.
struct InitialGuess {
  std::vector<double> q, v;
  std::vector<bool> q_fixed, v_fixed;      // kept exactly
  std::vector<double> q_weight, v_weight;  // in the squared distance that is minimized; 0: no preference
  std::vector<bool> q_given, v_given;      // given by the user; the others may take any value
  std::vector<bool> turns;                 // coordinate is an angle, equivalent modulo 2 pi
  // Of two assemblies that are equally near, that with the larger value of the first coordinate by rank in which they
  // differ is taken: the ranks and the user's signs do not depend on the order of the file or on the cuts.
  std::vector<int> rank;
  std::vector<double> user_sign;
};

struct Assembled {
  std::vector<double> q, v;     // of the tree joints
  std::vector<double> equal_q;  // another assembly that is as near to the guesses; empty: none is known
  double moved = 0;  // largest change of a coordinate that was given but not fixed, cut joints included [rad, m]
  int tries = 1;     // number of starts until the loops closed
  double gap = 0;    // m or rad: largest closure error, relative to the mechanism's length
};

// A fixed coordinate or velocity, or the three velocities of a quaternion, as indices into the lists of InitialGuess.
struct FixedValue {
  bool cut = false;  // an index into the cut joints' lists
  int first = 0, count = 1;
  int q = -1;  // index of its (first) coordinate; -1: a velocity is fixed
};

// Fixed values that contradict each other.
struct Conflict {
  std::vector<FixedValue> values;  // without any one of them the others are consistent; empty: not known
  int freed = -1;      // index into values: if this one were a guess, all others could be satisfied; -1: none
  double nearest = 0;  // its value in that case
};

// Thrown if no start closes the loops: the joint with the largest closure error and the size of that error.
class CannotAssemble : public std::runtime_error {
 public:
  CannotAssemble(double gap, double turn, int cut, std::vector<double> q, Conflict conflict)
      : std::runtime_error("the loops cannot be closed"),
        gap(gap),
        turn(turn),
        cut(cut),
        q(std::move(q)),
        conflict(std::move(conflict)) {}
  double gap, turn;  // m, rad: closure error of that joint; for velocities the residual rate [m/s, rad/s], and 0
  int cut;  // index of the cut joint, or number of cuts + coordinate row; -1: positions close, fixed velocities do not
  std::vector<double> q;  // position with the smallest closure error
  Conflict conflict;
};

// Finds the position and the velocities that close the loops with the smallest weighted change of the guesses of all
// joints, whether they are in the tree or cut; fixed values are kept. Among those that change given values least, the
// other values change least. Groups of loops that share no joint are closed one by one (loop_groups.h).
// Throws CannotAssemble with the smallest closure error reached for positions, or the residual rate for velocities.
Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts);

}  // namespace gelenk
