// SPDX-License-Identifier: BSD-3-Clause
// Edges that cross: whether they are where the shapes touch.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "contact_geometry/contact_candidates.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Normals up to this beyond those of a face belong to its edge, too: faces that lie on each other touch at their edges.
constexpr double angle_rounding = 1e-9;
// Depths below this are rounding [natural units of length].
constexpr double depth_rounding = 1e-9;

// The least cosine of the angles between n and the normals of the faces at an edge: n points between them if it is
// positive.
double least_cosine(const std::array<Vector3d, 2>& normals, const Vector3d& n) {
  return std::min(n.dot(normals[0]), n.dot(normals[1]));
}

}  // namespace

ContactCandidates::Crossing ContactCandidates::crossing(const ContactCandidate& candidate) const {
  const PlacedEdge& tip = placed_edge(candidate.placed_tip_edge);
  const PlacedEdge& core = placed_edge(candidate.placed_core_edge);
  return features::crossing<double>(candidate, {.tip = {tip.center, tip.direction, tip.outward},
                                                .core = {core.center, core.direction, core.outward}});
}

double ContactCandidates::left(const ContactCandidate& candidate, const Crossing& at) {
  if (at.is_parallel()) return -1;
  return std::min(candidate.tip_edge.half - std::abs(at.s), candidate.core_edge.half - std::abs(at.t));
}

double ContactCandidates::margin(const ContactCandidate& candidate, const Crossing& at) {
  return std::min(left(candidate, at), at.sine - features::least_sine);
}

// Whether n points out of the core, and -n out of the tip.
bool ContactCandidates::is_outside(const ContactCandidate& candidate, const Crossing& at) const {
  if (at.is_parallel()) return false;
  const PlacedEdge& tip = placed_edge(candidate.placed_tip_edge);
  const PlacedEdge& core = placed_edge(candidate.placed_core_edge);
  const double least = std::min(candidate.core_edge.is_sharp() ? least_cosine(core.normals, at.n) : 1.0,
                                candidate.tip_edge.is_sharp() ? least_cosine(tip.normals, -at.n) : 1.0);
  // Where faces lie on each other, edges may be deep in the direction of one of their faces, but not of the other.
  return least >= -angle_rounding && (at.gap > -depth_rounding || -at.gap * least > depth_rounding);
}

bool ContactCandidates::is_near(const ContactCandidate& candidate, const Crossing& at) const {
  if (margin(candidate, at) < -features::near_tolerance || !is_outside(candidate, at)) return false;
  if (at.gap > -depth_rounding || !candidate.core_edge.is_sharp()) return true;
  // Edges on far sides of both solids seem to be deep inside.
  const Pose3& X_0S = core_pose(candidate);
  const Vector3d x = X_0S.R.transpose() * (at.p_a - candidate.tip_edge.radius * at.n - X_0S.p);
  return ((x.cwiseAbs() - candidate.box.half).array() <= features::near_tolerance).all();
}

features::Lowest<double> ContactCandidates::lowest(const ContactCandidate& candidate) const {
  return features::lowest<double>(candidate, pose(candidate.tip_link), core_pose(candidate));
}

features::PairMotion<double> ContactCandidates::pair_motion(const ContactCandidate& candidate) const {
  return {.tip = pose(candidate.tip_link),
          .core = pose(candidate.core_link),
          .S = core_pose(candidate),
          .V_tip = velocity(candidate.tip_link),
          .V_core = velocity(candidate.core_link)};
}

}  // namespace gelenk
