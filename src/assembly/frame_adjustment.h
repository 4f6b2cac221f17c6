// SPDX-License-Identifier: BSD-3-Clause
// Overconstrained loops close at all positions only if their dimensions fit exactly. Dimensions printed with a few
// digits do not: here the frames of the joints are moved by the smallest amount that makes them fit.
//
// Unknowns are small twists d of all frames (6 numbers each) and the coordinates q_k of several positions along the
// motion; all of Phi(q_k, d) = 0 is solved by Gauss-Newton steps, d of minimum norm, q_k unweighted. With J_k = U S V^T
// at rank r, the columns L_k of U beyond r are the combinations of equations that no motion can satisfy, so that
//   L_k^T (Phi_k + A_k d) = 0 for all k                gives d, of minimum norm and truncated rank,
//   dq_k = -J_k^+ (Phi_k + A_k d), truncated at r      the positions.
// Axes that are parallel in a link up to the tolerance are made exactly parallel first and kept so: at parallel axes
// the conditions are singular (neighbors of a planar linkage are spherical ones with a distant center), and the steps
// would converge slowly to one of these. Rank truncation: Golub & Van Loan, Matrix Computations, sec. 5.5.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// A frame that was moved: X_given -> X_given * X_move in its link.
struct FrameMove {
  int scene_joint = -1;
  bool child = false;
  Pose3 X_given;  // of the joint's canonical frame in the link
  Pose3 X_move;
  double turn = 0, shift = 0;  // rad, m
};

struct FrameAdjustment {
  enum class Outcome {
    as_given,  // nothing was moved: the loops close exactly, or their equations are not redundant
    adjusted,
    too_far,  // some frame would have to move by more than the tolerance
    none,     // no exact mechanism was found nearby
  };
  Outcome outcome = Outcome::as_given;
  std::vector<FrameMove> moves;  // also for too_far
  double gap = 0;                // m, rad: largest closure error of the mechanism as given, at the positions examined
  int degrees_of_freedom = 0;    // of the adjusted loops
  double max_move() const;       // the largest turn [rad] or shift [m]
};

// Moves the joint frames of a spatial mechanism without rods. q: a position near the start. tolerance: in rad and in
// the mechanism's unit of length.
FrameAdjustment adjust_frames(const Mechanism& mechanism, const std::vector<double>& q, double tolerance);

}  // namespace gelenk
