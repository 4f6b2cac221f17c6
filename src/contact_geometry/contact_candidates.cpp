// SPDX-License-Identifier: BSD-3-Clause
#include "contact_geometry/contact_candidates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/bitwise.h"
#include "mechanism/touching.h"
#include "shape/kinds.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Of a ball about the origin of a shape's frame that contains it, and all that counts as touching it [m]; infinite:
// unknown.
double radius_of(const AnyShape& shape) {
  constexpr double margin = 1e-6;
  double out = 0;
  if (const auto core = core_of(shape)) {
    if (core->half_space) return INFINITY;
    out = core->half.norm() + core->radius;
  } else {
    const std::vector<Tip> tips = tips_of(shape);
    if (tips.empty()) return INFINITY;
    for (const Tip& tip : tips) out = std::max(out, tip.center.norm() + tip.radius);
  }
  return out + margin;
}

// Of a ball about the origin of a shape's frame that contains it [m].
double arm_of(const AnyShape& shape) {
  const Aabb box = bounds(shape, Pose3());
  return box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
}

}  // namespace

ContactCandidates::ContactCandidates(const Mechanism& mechanism, bool located)
    : poses_(mechanism.links.size()),
      core_poses_(mechanism.shapes.size()),
      V_(mechanism.links.size()),
      A_(mechanism.links.size()) {
  if (located) {
    add_shapes(mechanism);
    for (const Swing& swing : mechanism.swings) add_swing(swing);
    for (const LinkFriction& friction : mechanism.frictions) add_friction(friction);
  }
  std::ranges::sort(links_);
  links_.erase(std::unique(links_.begin(), links_.end()), links_.end());
  std::vector<bool> is_core(core_poses_.size());
  for (int i = 0; i < count(); ++i) {
    if (!(*this)[i].has_shapes()) continue;
    const auto core = static_cast<std::size_t>((*this)[i].core);
    if (!is_core[core]) cores_.push_back(i);
    is_core[core] = true;
  }
}

void ContactCandidates::add_shapes(const Mechanism& mechanism) {
  const auto& shapes = mechanism.shapes;
  const int n = static_cast<int>(shapes.size());
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      const LinkShape& first = shapes[static_cast<std::size_t>(i)];
      const LinkShape& second = shapes[static_cast<std::size_t>(j)];
      const int contact = contact_between(mechanism.contact_table, first, second);
      if (contact < 0) continue;
      begin_pair(mechanism, i, j);
      // Other pairs have been refused (check/elements.cpp).
      if (tips_touch_core(*first.is, *second.is)) {
        add_pair(mechanism, contact, i, j);
      } else if (tips_touch_core(*second.is, *first.is)) {
        add_pair(mechanism, contact, j, i);
      } else if (edges_touch(*first.is, *second.is)) {
        add_pair(mechanism, contact, i, j);
        add_pair(mechanism, contact, j, i);
        const bool second_is_sharp = edges_of(*second.is).front().is_sharp();  // the core is, if one of them is
        add_edges(mechanism, contact, second_is_sharp ? i : j, second_is_sharp ? j : i);
      } else if (rims_touch_plane(*first.is, *second.is)) {
        add_rims(mechanism, contact, i, j);
      } else if (rims_touch_plane(*second.is, *first.is)) {
        add_rims(mechanism, contact, j, i);
      }
    }
  }
}

void ContactCandidates::begin_pair(const Mechanism& mechanism, int tip, int core) {
  const LinkShape& a = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& b = mechanism.shapes[static_cast<std::size_t>(core)];
  Pair& pair = pairs_.emplace_back();
  pair.first = count();
  pair.core_link = b.link;
  pair.tip_link = a.link;
  pair.core = b.X_LS.p;
  pair.tip = a.X_LS.p;
  pair.reach = radius_of(*a.is) + radius_of(*b.is);
  pair.tip_arm = arm_of(*a.is);
  pair.core_arm = arm_of(*b.is);
}

ContactCandidates::Range ContactCandidates::range(int pair) const {
  const auto i = static_cast<std::size_t>(pair);
  return {pairs_[i].first, i + 1 < pairs_.size() ? pairs_[i + 1].first : count()};
}

bool ContactCandidates::tip_is_smaller(int pair) const {
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  return of.tip_arm <= of.core_arm;
}

ContactCandidates::Approach ContactCandidates::approach(int pair, bool of_tip) const {
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  const int moving = of_tip ? of.tip_link : of.core_link;
  const int other = of_tip ? of.core_link : of.tip_link;
  if (const ContactCandidate& swing = (*this)[of.first]; swing.turns()) {
    const Eigen::Matrix3d R = pose(of.core_link).R.transpose();
    const Vector3d b = pose(of.tip_link).R * swing.tip_axis;
    const Vector3d w = velocity(of.tip_link).w - velocity(of.core_link).w;
    return {.p = R * b, .v = R * w.cross(b), .w = R * w, .arm = 0};
  }
  const Vector3d p = pose(moving).point(of_tip ? of.tip : of.core);
  const Vector3d w = velocity(moving).w - velocity(other).w;
  const Vector3d v = velocity(moving).v - velocity(other).v + w.cross(p);
  const Eigen::Matrix3d R = pose(other).R.transpose();
  return {.p = R * (p - pose(other).p), .v = R * v, .w = R * w, .arm = of_tip ? of.tip_arm : of.core_arm};
}

Vector3d ContactCandidates::between(const Pair& pair) const {
  return pose(pair.tip_link).point(pair.tip) - pose(pair.core_link).point(pair.core);
}

double ContactCandidates::distance(int candidate, double& rate) const {
  const Pair& pair = pair_of(candidate);
  const Vector3d way = between(pair);
  const auto speed = [&](int link, const Vector3d& center) {
    return Vector3d(velocity(link).v + velocity(link).w.cross(pose(link).point(center)));
  };
  rate = way.normalized().dot(speed(pair.tip_link, pair.tip) - speed(pair.core_link, pair.core));
  return way.norm() - pair.reach;
}

// What all candidates of a pair have in common.
ContactCandidate ContactCandidates::candidate_between(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_tips = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& with_core = mechanism.shapes[static_cast<std::size_t>(core)];
  const bool core_is_first = mechanism.contact_table.is_first(contact, with_core.surface) &&
                             (with_core.surface != with_tips.surface || core < tip);
  const LinkShape& belt = core_is_first ? with_tips : with_core;
  ContactCandidate candidate;
  candidate.pair = static_cast<int>(pairs_.size()) - 1;
  candidate.core = core;
  candidate.tip = tip;
  candidate.core_link = with_core.link;
  candidate.tip_link = with_tips.link;
  candidate.contact = contact;
  candidate.sign = core_is_first ? 1 : -1;
  candidate.X_LS = with_core.X_LS;
  candidate.X_tip = with_tips.X_LS;
  candidate.box = *core_of(*with_core.is);
  candidate.size = std::min(size_of(*with_core.is), size_of(*with_tips.is));
  candidate.R_belt = belt.X_LS.R;
  links_.push_back(with_core.link);
  links_.push_back(with_tips.link);
  return candidate;
}

void ContactCandidates::add_pair(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_tips = mechanism.shapes[static_cast<std::size_t>(tip)];
  ContactCandidate candidate = candidate_between(mechanism, contact, tip, core);
  const std::vector<Tip> tips = tips_of(*with_tips.is);
  Vector3d middle = Vector3d::Zero();
  for (const Tip& at : tips) middle += at.center / static_cast<double>(tips.size());
  for (const Tip& at : tips) {
    candidate.feature = at.feature;
    candidate.center = with_tips.X_LS.point(at.center);
    candidate.way = with_tips.X_LS.R * (at.center - middle);
    candidate.radius = at.radius;
    const bool sharp = !candidate.box.half_space && candidate.box.radius == 0 && at.radius == 0;
    if (sharp) {
      add_corner(candidate);
    } else {
      candidates_.push_back(candidate);
    }
  }
}

void ContactCandidates::add_corner(const ContactCandidate& candidate) {
  for (int face = 0; face < 6; ++face) {
    ContactCandidate& at = candidates_.emplace_back(candidate);
    at.kind = ContactCandidate::Kind::corner;
    at.face = face;
  }
}

void ContactCandidates::add_edges(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& a = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& b = mechanism.shapes[static_cast<std::size_t>(core)];
  const auto in_link = [](const Pose3& X, SolidEdge edge) {
    edge.center = X.point(edge.center);
    edge.direction = X.R * edge.direction;
    for (Vector3d& normal : edge.normals) normal = X.R * normal;
    return edge;
  };
  ContactCandidate candidate = candidate_between(mechanism, contact, tip, core);
  candidate.kind = ContactCandidate::Kind::edges;
  std::vector<int> placed_core_edges;
  for (const SolidEdge& of_core : edges_of(*b.is))
    placed_core_edges.push_back(place_edge(candidate.core_link, in_link(b.X_LS, of_core)));
  for (const SolidEdge& of_tip : edges_of(*a.is)) {
    candidate.tip_edge = in_link(a.X_LS, of_tip);
    candidate.placed_tip_edge = place_edge(candidate.tip_link, candidate.tip_edge);
    for (const int of_core : placed_core_edges) {
      candidate.core_edge = placed_edge(of_core).edge;
      candidate.placed_core_edge = of_core;
      candidates_.push_back(candidate);
    }
  }
}

// Of the last pair.
int ContactCandidates::place_edge(int link, const SolidEdge& edge) {
  PlacedEdge& out = edges_.emplace_back();
  out.pair = static_cast<int>(pairs_.size()) - 1;
  out.link = link;
  out.edge = edge;
  return static_cast<int>(edges_.size()) - 1;
}

void ContactCandidates::add_rims(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_rims = mechanism.shapes[static_cast<std::size_t>(tip)];
  ContactCandidate candidate = candidate_between(mechanism, contact, tip, core);
  candidate.kind = ContactCandidate::Kind::rim;
  for (const SolidRim& rim : rims_of(*with_rims.is)) {
    candidate.tip_edge.center = with_rims.X_LS.point(rim.center);
    candidate.tip_edge.direction = with_rims.X_LS.R * rim.axis;
    candidate.radius = rim.radius;
    candidate.crown = rim.crown;
    candidates_.push_back(candidate);
  }
}

void ContactCandidates::read_position(Dynamics& dynamics) {
  // What rests is looked at again and again at the same position.
  dynamics.readings().set_root_poses();
  bool any_moved = !has_position_;
  for (const int link : links_) {
    if (link == 0) continue;
    const Pose3 X = dynamics.readings().link_pose(link);
    Pose3& known = poses_[static_cast<std::size_t>(link)];
    any_moved = any_moved || !is_bitwise_equal(X, known);
    known = X;
  }
  if (!any_moved) return;
  has_position_ = true;
  for (const int i : cores_) {
    const ContactCandidate& of = (*this)[i];
    core_poses_[static_cast<std::size_t>(of.core)] = pose(of.core_link) * of.X_LS;
  }
  for (Pair& pair : pairs_) pair.is_close = !(between(pair).squaredNorm() > pair.reach * pair.reach);
  for (PlacedEdge& at : edges_) {
    if (!pairs_[static_cast<std::size_t>(at.pair)].is_close) continue;
    const Pose3& X = pose(at.link);
    at.center = X.point(at.edge.center);
    at.direction = X.R * at.edge.direction;
    if (!at.edge.is_sharp()) continue;
    for (std::size_t k = 0; k < 2; ++k) at.normals[k] = X.R * at.edge.normals[k];
    at.outward = X.R * (at.edge.normals[0] + at.edge.normals[1]);
  }
}

void ContactCandidates::read_motion(Dynamics& dynamics) {
  read_position(dynamics);
  for (const int link : links_) {
    const auto i = static_cast<std::size_t>(link);
    if (link > 0) V_[i] = poses_[i].to_parent(dynamics.readings().link_velocity(link));
    A_[i] = poses_[i].to_parent(dynamics.readings().link_bias_acceleration(link));
  }
}

Vector3d ContactCandidates::center(const ContactCandidate& candidate) const {
  const Pose3& X_0S = core_pose(candidate);
  return X_0S.R.transpose() * (pose(candidate.tip_link).point(candidate.center) - X_0S.p);
}

ContactCandidates::Line ContactCandidates::line(const ContactCandidate& candidate) const {
  return features::line<double>(candidate, center(candidate));
}

// Of a tip, in S.
Vector3d ContactCandidates::way_to_tip(const ContactCandidate& candidate) const {
  return core_pose(candidate).R.transpose() * (pose(candidate.tip_link).R * candidate.way);
}

double ContactCandidates::gap(int candidate) const {
  const ContactCandidate& at = (*this)[candidate];
  if (at.is_given()) return 0;
  if (at.kind == ContactCandidate::Kind::swing)
    return features::gap_of_swing<double>(at, pose(at.core_link).R * at.core_axis, pose(at.tip_link).R * at.tip_axis);
  if (at.kind == ContactCandidate::Kind::edges) return crossing(at).gap;
  if (at.kind == ContactCandidate::Kind::rim) return lowest(at).gap;
  return line(at).distance - at.box.radius - at.radius;
}

double ContactCandidates::margin(int candidate) const {
  const ContactCandidate& at = (*this)[candidate];
  switch (at.kind) {
    case ContactCandidate::Kind::tip:
    case ContactCandidate::Kind::swing:
    case ContactCandidate::Kind::friction:
      return at.size;
    case ContactCandidate::Kind::corner: {
      const Vector3d left = at.box.half - center(at).cwiseAbs();
      const int axis = at.face % 3;
      return std::min(left[(axis + 1) % 3], left[(axis + 2) % 3]);
    }
    case ContactCandidate::Kind::edges: {
      return margin(at, crossing(at));
    }
    default:
      return at.radius > 0 ? lowest(at).sine - features::flat_sine : at.size;
  }
}

bool ContactCandidates::is_near(int candidate) const {
  const ContactCandidate& at = (*this)[candidate];
  if (at.kind == ContactCandidate::Kind::tip || at.kind == ContactCandidate::Kind::rim || !at.has_shapes()) return true;
  if (at.kind == ContactCandidate::Kind::edges) return is_near(at, crossing(at));
  if (margin(candidate) < -features::near_tolerance) return false;
  // A corner that touches a face is ahead of its body, which is on the outer side; on the inner side of a thin plate
  // is the face beyond.
  const Line from = line(at);
  if (from.normal.dot(way_to_tip(at)) > 0) return false;
  // Of all faces, the opposite one included, the one that touches is nearest if the corner is inside the box, and the
  // only one that it is beyond if it is outside.
  return from.distance >= (center(at).cwiseAbs() - at.box.half).maxCoeff() - features::near_tolerance;
}

RelativeMotion ContactCandidates::motion(int candidate) const {
  const auto a = static_cast<std::size_t>((*this)[candidate].core_link);
  const auto b = static_cast<std::size_t>((*this)[candidate].tip_link);
  return {V_[b] - V_[a], A_[b] - A_[a]};
}

CandidateState ContactCandidates::state(int candidate) const {
  const ContactCandidate& at = (*this)[candidate];
  const features::PairMotion<double> motion = pair_motion(at);
  // The edges are placed once for all candidates of a pair.
  if (at.kind == ContactCandidate::Kind::edges) return features::state_of_edges(at, crossing(at), motion);
  return features::state(at, motion);
}

Vector3d ContactCandidates::belt(int candidate, const Vector3d& velocity, Vector3d& rate) const {
  const ContactCandidate& at = (*this)[candidate];
  const int link = at.sign > 0 ? at.tip_link : at.core_link;
  const Vector3d out = at.sign * (pose(link).R * (at.R_belt * velocity));
  rate = V_[static_cast<std::size_t>(link)].w.cross(out);
  return out;
}

}  // namespace gelenk
