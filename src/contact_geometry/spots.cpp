// SPDX-License-Identifier: BSD-3-Clause
#include "contact_geometry/spots.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_geometry/spot_features.h"
#include "mechanism/touching.h"
#include "shape/kinds.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// What is nearer to a point or an edge of a core than this fraction of the radii counts as being on it.
constexpr double least_distance = 1e-12;

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

Spots::Spots(const Mechanism& mechanism, bool located)
    : poses_(mechanism.links.size()), V_(mechanism.links.size()), A_(mechanism.links.size()) {
  const auto& shapes = mechanism.shapes;
  const int n = located ? static_cast<int>(shapes.size()) : 0;
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
  std::ranges::sort(links_);
  links_.erase(std::unique(links_.begin(), links_.end()), links_.end());
}

void Spots::begin_pair(const Mechanism& mechanism, int tip, int core) {
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

Spots::Range Spots::range(int pair) const {
  const auto i = static_cast<std::size_t>(pair);
  return {pairs_[i].first, i + 1 < pairs_.size() ? pairs_[i + 1].first : count()};
}

bool Spots::tip_is_smaller(int pair) const {
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  return of.tip_arm <= of.core_arm;
}

Spots::Approach Spots::approach(int pair, bool of_tip) const {
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  const int moving = of_tip ? of.tip_link : of.core_link;
  const int other = of_tip ? of.core_link : of.tip_link;
  const Vector3d p = pose(moving).point(of_tip ? of.tip : of.core);
  const Vector3d w = velocity(moving).w - velocity(other).w;
  const Vector3d v = velocity(moving).v - velocity(other).v + w.cross(p);
  const Eigen::Matrix3d R = pose(other).R.transpose();
  return {.p = R * (p - pose(other).p), .v = R * v, .w = R * w, .arm = of_tip ? of.tip_arm : of.core_arm};
}

Vector3d Spots::between(const Pair& pair) const {
  return pose(pair.tip_link).point(pair.tip) - pose(pair.core_link).point(pair.core);
}

double Spots::distance(int spot, double& rate) const {
  const Pair& pair = pair_of(spot);
  const Vector3d way = between(pair);
  const auto speed = [&](int link, const Vector3d& center) {
    return Vector3d(velocity(link).v + velocity(link).w.cross(pose(link).point(center)));
  };
  rate = way.normalized().dot(speed(pair.tip_link, pair.tip) - speed(pair.core_link, pair.core));
  return way.norm() - pair.reach;
}

// What all spots of a pair have in common.
Spot Spots::spot_between(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_tips = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& with_core = mechanism.shapes[static_cast<std::size_t>(core)];
  const bool core_is_first = mechanism.contact_table.is_first(contact, with_core.surface) &&
                             (with_core.surface != with_tips.surface || core < tip);
  const LinkShape& belt = core_is_first ? with_tips : with_core;
  Spot spot;
  spot.pair = static_cast<int>(pairs_.size()) - 1;
  spot.core = core;
  spot.tip = tip;
  spot.core_link = with_core.link;
  spot.tip_link = with_tips.link;
  spot.contact = contact;
  spot.sign = core_is_first ? 1 : -1;
  spot.X_LS = with_core.X_LS;
  spot.X_tip = with_tips.X_LS;
  spot.box = *core_of(*with_core.is);
  spot.size = std::min(size_of(*with_core.is), size_of(*with_tips.is));
  spot.R_belt = belt.X_LS.R;
  links_.push_back(with_core.link);
  links_.push_back(with_tips.link);
  return spot;
}

void Spots::add_pair(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_tips = mechanism.shapes[static_cast<std::size_t>(tip)];
  Spot spot = spot_between(mechanism, contact, tip, core);
  const std::vector<Tip> tips = tips_of(*with_tips.is);
  Vector3d middle = Vector3d::Zero();
  for (const Tip& at : tips) middle += at.center / static_cast<double>(tips.size());
  for (const Tip& at : tips) {
    spot.feature = at.feature;
    spot.center = with_tips.X_LS.point(at.center);
    spot.way = with_tips.X_LS.R * (at.center - middle);
    spot.radius = at.radius;
    const bool sharp = !spot.box.half_space && spot.box.radius == 0 && at.radius == 0;
    if (sharp) {
      add_corner(spot);
    } else {
      spots_.push_back(spot);
    }
  }
}

void Spots::add_corner(const Spot& spot) {
  for (int face = 0; face < 6; ++face) {
    Spot& at = spots_.emplace_back(spot);
    at.kind = Spot::Kind::corner;
    at.face = face;
  }
}

void Spots::add_edges(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& a = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& b = mechanism.shapes[static_cast<std::size_t>(core)];
  const auto in_link = [](const Pose3& X, SolidEdge edge) {
    edge.center = X.point(edge.center);
    edge.direction = X.R * edge.direction;
    for (Vector3d& normal : edge.normals) normal = X.R * normal;
    return edge;
  };
  Spot spot = spot_between(mechanism, contact, tip, core);
  spot.kind = Spot::Kind::edges;
  for (const SolidEdge& of_tip : edges_of(*a.is)) {
    for (const SolidEdge& of_core : edges_of(*b.is)) {
      spot.tip_edge = in_link(a.X_LS, of_tip);
      spot.core_edge = in_link(b.X_LS, of_core);
      spots_.push_back(spot);
    }
  }
}

void Spots::add_rims(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_rims = mechanism.shapes[static_cast<std::size_t>(tip)];
  Spot spot = spot_between(mechanism, contact, tip, core);
  spot.kind = Spot::Kind::rim;
  for (const SolidRim& rim : rims_of(*with_rims.is)) {
    spot.tip_edge.center = with_rims.X_LS.point(rim.center);
    spot.tip_edge.direction = with_rims.X_LS.R * rim.axis;
    spot.radius = rim.radius;
    spot.crown = rim.crown;
    spots_.push_back(spot);
  }
}

void Spots::read_position(Dynamics& dynamics) {
  dynamics.readings().set_root_poses();
  for (const int link : links_) {
    if (link > 0) poses_[static_cast<std::size_t>(link)] = dynamics.readings().link_pose(link);
  }
  for (Pair& pair : pairs_) pair.is_close = !(between(pair).squaredNorm() > pair.reach * pair.reach);
}

void Spots::read_motion(Dynamics& dynamics) {
  read_position(dynamics);
  for (const int link : links_) {
    const auto i = static_cast<std::size_t>(link);
    if (link > 0) V_[i] = poses_[i].to_parent(dynamics.readings().link_velocity(link));
    A_[i] = poses_[i].to_parent(dynamics.readings().link_bias_acceleration(link));
  }
}

Vector3d Spots::center(const Spot& spot) const {
  const Pose3 X_0S = pose(spot.core_link) * spot.X_LS;
  return X_0S.R.transpose() * (pose(spot.tip_link).point(spot.center) - X_0S.p);
}

Spots::Line Spots::line(const Spot& spot) const {
  Line out;
  out.x = center(spot);
  if (spot.kind == Spot::Kind::corner) {
    const int axis = spot.face % 3;
    out.free = Vector3d::Unit(axis);
    out.normal = spot.face < 3 ? out.free : Vector3d(-out.free);
    out.distance = out.normal.dot(out.x) - spot.box.half[axis];
    return out;
  }
  if (spot.box.half_space) {
    out.normal = out.free = Vector3d::UnitZ();
    out.distance = out.x.z();
    return out;
  }
  const Vector3d& half = spot.box.half;
  out.free = (out.x.cwiseAbs().array() > half.array()).select(Vector3d::Ones(), Vector3d::Zero());
  const Vector3d way = out.x - out.x.cwiseMax(-half).cwiseMin(half);
  out.distance = way.norm();
  if (out.distance > least_distance * (spot.radius + spot.box.radius)) {
    out.normal = way / out.distance;
    return out;
  }
  // Inside: the nearest face.
  int axis = 0;
  const Vector3d depth = half - out.x.cwiseAbs();
  depth.minCoeff(&axis);
  out.free = Vector3d::Unit(axis);
  out.normal = out.x[axis] < 0 ? Vector3d(-out.free) : out.free;
  out.distance = -depth[axis];
  return out;
}

// Of a tip, in S.
Vector3d Spots::way_to_tip(const Spot& spot) const {
  const Eigen::Matrix3d R_0S = pose(spot.core_link).R * spot.X_LS.R;
  return R_0S.transpose() * (pose(spot.tip_link).R * spot.way);
}

double Spots::gap(int spot) const {
  const Spot& at = (*this)[spot];
  if (at.kind == Spot::Kind::edges) return crossing(at).gap;
  if (at.kind == Spot::Kind::rim) return lowest(at).gap;
  return line(at).distance - at.box.radius - at.radius;
}

double Spots::margin(int spot) const {
  const Spot& at = (*this)[spot];
  switch (at.kind) {
    case Spot::Kind::tip:
      return at.size;
    case Spot::Kind::corner: {
      const Vector3d left = at.box.half - center(at).cwiseAbs();
      const int axis = at.face % 3;
      return std::min(left[(axis + 1) % 3], left[(axis + 2) % 3]);
    }
    case Spot::Kind::edges: {
      const Crossing on = crossing(at);
      return std::min(on.left, on.sine - least_sine);
    }
    default:
      return at.radius > 0 ? lowest(at).sine - flat_sine : at.size;
  }
}

bool Spots::is_near(int spot) const {
  const Spot& at = (*this)[spot];
  if (at.kind == Spot::Kind::tip || at.kind == Spot::Kind::rim) return true;
  if (margin(spot) < -near_tolerance) return false;
  if (at.kind == Spot::Kind::edges) return is_near(at, crossing(at));
  // A corner that touches a face is ahead of its body, which is on the outer side; on the inner side of a thin plate
  // is the face beyond.
  const Line from = line(at);
  if (from.normal.dot(way_to_tip(at)) > 0) return false;
  // Of all faces, the opposite one included, the one that touches is nearest if the corner is inside the box, and the
  // only one that it is beyond if it is outside.
  return from.distance >= (center(at).cwiseAbs() - at.box.half).maxCoeff() - near_tolerance;
}

RelativeMotion Spots::motion(int spot) const {
  const auto a = static_cast<std::size_t>((*this)[spot].core_link);
  const auto b = static_cast<std::size_t>((*this)[spot].tip_link);
  return {V_[b] - V_[a], A_[b] - A_[a]};
}

SpotState Spots::state(int spot) const {
  const Spot& at = (*this)[spot];
  if (at.kind == Spot::Kind::edges) return state_of_edges(at);
  if (at.kind == Spot::Kind::rim) return state_of_rim(at);
  const Line way = line(at);
  const Eigen::Matrix3d R_0S = pose(at.core_link).R * at.X_LS.R;
  const Spatial::Motion& V_core = V_[static_cast<std::size_t>(at.core_link)];
  const Spatial::Motion& V_tip = V_[static_cast<std::size_t>(at.tip_link)];
  const Vector3d center = pose(at.tip_link).point(at.center);
  const Vector3d center_dot = V_tip.v + V_tip.w.cross(center);
  const Vector3d x_dot = R_0S.transpose() * motion(spot).velocity(center);
  const Vector3d way_dot = way.free.cwiseProduct(x_dot);
  SpotState out;
  out.gap = way.distance - at.box.radius - at.radius;
  out.n = R_0S * way.normal;
  out.rate = way.normal.dot(way_dot);
  out.n_dot = V_core.w.cross(out.n);
  const bool is_flat = at.box.half_space || at.kind == Spot::Kind::corner;
  if (!is_flat && way.distance > 0) out.n_dot += R_0S * (way_dot - out.rate * way.normal) / way.distance;
  const double arm = at.radius + out.gap / 2;
  out.p = center - arm * out.n;
  out.p_dot = center_dot - arm * out.n_dot - out.rate / 2 * out.n;
  return out;
}

Vector3d Spots::belt(int spot, const Vector3d& velocity, Vector3d& rate) const {
  const Spot& at = (*this)[spot];
  const int link = at.sign > 0 ? at.tip_link : at.core_link;
  const Vector3d out = at.sign * (pose(link).R * (at.R_belt * velocity));
  rate = V_[static_cast<std::size_t>(link)].w.cross(out);
  return out;
}

}  // namespace gelenk
