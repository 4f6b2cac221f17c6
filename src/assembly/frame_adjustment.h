// SPDX-License-Identifier: BSD-3-Clause
// Loops whose joints are redundant close at all positions only if their dimensions fit each other exactly. Numbers
// printed with a few digits do not: here the frames of the joints are moved by the least that makes them fit.
//
// Unknown are small twists d of all frames (6 numbers each) and the coordinates q_k of several positions along the
// motion; all of Phi(q_k, d) = 0 is solved by Gauss-Newton steps, d of minimum norm, q_k free of cost. With J_k = U S
// V^T at rank r, the columns L_k of U beyond r are the combinations of equations that no motion serves, so that
//   L_k^T (Phi_k + A_k d) = 0 for all k                gives d, of minimum norm and truncated rank,
//   dq_k = -J_k^+ (Phi_k + A_k d), truncated at r      the positions.
// Axes that are parallel in a link up to the tolerance are made so first, and stay so: at parallel axes the conditions
// are singular (neighbours of a planar linkage are spherical ones with a far centre), and the steps would converge
// slowly to one of these. Rank truncation: Golub & Van Loan, Matrix Computations, sec. 5.5.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// A frame that was moved: X_given -> X_given * X_move in its link.
struct FrameMove {
  int scene_joint = -1;
  bool child = false;
  Pose3 X_given;  // of the joint's frame, canonical, in the link
  Pose3 X_move;
  double turn = 0, shift = 0;  // rad, m
};

struct FrameAdjustment {
  enum class Outcome {
    as_given,  // nothing was moved: the loops are exact, or their equations are not redundant
    adjusted,
    too_far,  // some frame would have to move by more than the tolerance
    none,     // no exact mechanism was found near the one given
  };
  Outcome outcome = Outcome::as_given;
  std::vector<FrameMove> moves;  // also of too_far
  double gap = 0;                // m, rad: the largest of the mechanism as given, at the positions looked at
  int degrees_of_freedom = 0;    // of the loops, adjusted
  double most() const;           // the largest turn or shift
};

// mechanism: in space, without rods made of massless links. q: near the start. tolerance: rad and m (or what unit the
// mechanism is in).
FrameAdjustment adjust_frames(const Mechanism& mechanism, const std::vector<double>& q, double tolerance);

}  // namespace gelenk
