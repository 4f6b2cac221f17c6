// SPDX-License-Identifier: BSD-3-Clause
#include "contact_geometry/candidate_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Normals up to this beyond those of a face belong to its edge, too: faces that lie on each other touch at their edges.
constexpr double angle_rounding = 1e-9;
// Depths below this are rounding [natural units of length].
constexpr double depth_rounding = 1e-9;
// Below this sine, the direction of the tilt is arbitrary.
constexpr double no_tilt = 1e-12;

// The least cosine of the angles between n and the normals of the faces at an edge: n points between them if it is
// positive.
double least_cosine(const std::array<Vector3d, 2>& normals, const Vector3d& n) {
  return std::min(n.dot(normals[0]), n.dot(normals[1]));
}

}  // namespace

ContactCandidates::Crossing ContactCandidates::crossing(const ContactCandidate& candidate) const {
  const SolidEdge& tip = candidate.tip_edge;
  const SolidEdge& core = candidate.core_edge;
  const PlacedEdge& tip_at = placed_edge(candidate.placed_tip_edge);
  const PlacedEdge& core_at = placed_edge(candidate.placed_core_edge);
  Crossing out;
  out.a = tip_at.direction;
  out.b = core_at.direction;
  out.d = tip_at.center - core_at.center;
  out.c = out.a.cross(out.b);
  out.sine = out.c.norm();
  if (!(out.sine > no_tilt)) {
    out.left = -1;
    out.n = Vector3d::UnitZ();
    out.p_a = tip_at.center;
    out.p_b = core_at.center;
    out.gap = candidate.size;
    return out;
  }
  Vector3d outward = out.d;
  if (core.is_sharp()) {
    outward = core_at.outward;
  } else if (tip.is_sharp()) {
    outward = -tip_at.outward;
  }
  out.sign = out.c.dot(outward) < 0 ? -1 : 1;
  out.n = out.sign / out.sine * out.c;
  const double k = out.a.dot(out.b);
  const double D = out.sine * out.sine;
  const double d_a = out.d.dot(out.a);
  const double d_b = out.d.dot(out.b);
  out.s = (k * d_b - d_a) / D;
  out.t = (d_b - k * d_a) / D;
  out.p_a = tip_at.center + out.s * out.a;
  out.p_b = core_at.center + out.t * out.b;
  out.gap = out.n.dot(out.d) - tip.radius - core.radius;
  out.left = std::min(tip.half - std::abs(out.s), core.half - std::abs(out.t));
  const double least = std::min(core.is_sharp() ? least_cosine(core_at.normals, out.n) : 1.0,
                                tip.is_sharp() ? least_cosine(tip_at.normals, -out.n) : 1.0);
  // Where faces lie on each other, edges may be deep in the direction of one of their faces, but not of the other.
  out.is_outside = least >= -angle_rounding && (out.gap > -depth_rounding || -out.gap * least > depth_rounding);
  return out;
}

bool ContactCandidates::is_near(const ContactCandidate& candidate, const Crossing& at) const {
  if (at.margin() < -near_tolerance || !at.is_outside) return false;
  if (at.gap > -depth_rounding || !candidate.core_edge.is_sharp()) return true;
  // Edges on far sides of both solids seem to be deep inside.
  const Pose3& X_0S = core_pose(candidate);
  const Vector3d x = X_0S.R.transpose() * (at.p_a - candidate.tip_edge.radius * at.n - X_0S.p);
  return ((x.cwiseAbs() - candidate.box.half).array() <= near_tolerance).all();
}

CandidateState ContactCandidates::state_of_edges(const ContactCandidate& candidate) const {
  const Crossing at = crossing(candidate);
  const Spatial::Motion& V_a = velocity(candidate.tip_link);
  const Spatial::Motion& V_b = velocity(candidate.core_link);
  CandidateState out;
  out.gap = at.gap;
  out.n = at.n;
  out.p = at.p_b + (candidate.core_edge.radius + at.gap / 2) * at.n;
  const auto velocity_of = [](const Spatial::Motion& V, const Vector3d& p) { return Vector3d(V.v + V.w.cross(p)); };
  out.rate = at.n.dot(velocity_of(V_a, at.p_a) - velocity_of(V_b, at.p_b));
  out.n_dot.setZero();
  out.p_dot.setZero();
  if (!(at.sine > no_tilt)) return out;
  const Vector3d a_dot = V_a.w.cross(at.a);
  const Vector3d b_dot = V_b.w.cross(at.b);
  const Vector3d c_dot = a_dot.cross(at.b) + at.a.cross(b_dot);
  out.n_dot = at.sign / at.sine * (c_dot - at.n.dot(c_dot) * at.n);
  // The rates of s and t, from (d + s a - t b) . a = 0 and (d + s a - t b) . b = 0.
  const Vector3d center_a = at.p_a - at.s * at.a;
  const Vector3d center_b = at.p_b - at.t * at.b;
  const Vector3d d_dot = velocity_of(V_a, center_a) - velocity_of(V_b, center_b);
  const Vector3d r = at.p_a - at.p_b;
  const Vector3d r_dot = d_dot + at.s * a_dot - at.t * b_dot;
  const double right_a = -(r_dot.dot(at.a) + r.dot(a_dot));
  const double right_b = -(r_dot.dot(at.b) + r.dot(b_dot));
  const double k = at.a.dot(at.b);
  const double D = at.sine * at.sine;
  const double t_dot = (k * right_a - right_b) / D;
  const Vector3d p_b_dot = velocity_of(V_b, center_b) + t_dot * at.b + at.t * b_dot;
  out.p_dot = p_b_dot + (candidate.core_edge.radius + at.gap / 2) * out.n_dot + out.rate / 2 * at.n;
  return out;
}

ContactCandidates::Lowest ContactCandidates::lowest(const ContactCandidate& candidate) const {
  const Pose3& X_tip = pose(candidate.tip_link);
  const Pose3& X_0S = core_pose(candidate);
  Lowest out;
  out.n = X_0S.R.col(2);
  out.axis = X_tip.R * candidate.tip_edge.direction;
  out.c = X_tip.point(candidate.tip_edge.center);
  const Vector3d across = out.n - out.n.dot(out.axis) * out.axis;
  out.sine = across.norm();
  out.e = out.sine > no_tilt ? Vector3d(across / out.sine) : Vector3d(out.axis.unitOrthogonal());
  out.gap = out.n.dot(out.c - X_0S.p) - candidate.radius * out.sine - candidate.crown;
  return out;
}

CandidateState ContactCandidates::state_of_rim(const ContactCandidate& candidate) const {
  const Lowest at = lowest(candidate);
  const Spatial::Motion& V_tip = velocity(candidate.tip_link);
  const Spatial::Motion& V_core = velocity(candidate.core_link);
  CandidateState out;
  out.gap = at.gap;
  out.n = at.n;
  out.n_dot = V_core.w.cross(at.n);
  const Vector3d lowest_point = at.c - candidate.radius * at.e;
  const double arm = candidate.crown + at.gap / 2;
  out.p = lowest_point - arm * at.n;
  const auto relative = [&](const Vector3d& p) {
    return Vector3d(V_tip.v + V_tip.w.cross(p) - V_core.v - V_core.w.cross(p));
  };
  out.rate = at.n.dot(relative(lowest_point));
  Vector3d e_dot = Vector3d::Zero();
  if (at.sine > no_tilt) {
    const Vector3d axis_dot = V_tip.w.cross(at.axis);
    const double cosine_rate = out.n_dot.dot(at.axis) + at.n.dot(axis_dot);
    const Vector3d across_dot = out.n_dot - cosine_rate * at.axis - at.n.dot(at.axis) * axis_dot;
    e_dot = (across_dot - at.e.dot(across_dot) * at.e) / at.sine;
  }
  out.p_dot = V_tip.v + V_tip.w.cross(at.c) - candidate.radius * e_dot - out.rate / 2 * at.n - arm * out.n_dot;
  return out;
}

}  // namespace gelenk
