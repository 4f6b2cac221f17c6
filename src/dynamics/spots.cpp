// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/spots.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mechanism/touching.h"
#include "shape/registry.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// What is nearer to a point or an edge of a core than this fraction of the radii counts as being on it.
constexpr double least_distance = 1e-12;

}  // namespace

Spots::Spots(const Mechanism& mechanism)
    : poses_(mechanism.links.size()), V_(mechanism.links.size()), A_(mechanism.links.size()) {
  const auto& shapes = mechanism.shapes;
  const int n = static_cast<int>(shapes.size());
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      const LinkShape& first = shapes[static_cast<std::size_t>(i)];
      const LinkShape& second = shapes[static_cast<std::size_t>(j)];
      const int contact = contact_between(mechanism.contact_table, first, second);
      if (contact < 0) continue;
      // Pairs without tips and core have been refused (check/elements.cpp).
      if (tips_touch_core(first.is, second.is)) {
        add_pair(mechanism, contact, i, j);
      } else if (tips_touch_core(second.is, first.is)) {
        add_pair(mechanism, contact, j, i);
      }
    }
  }
  std::ranges::sort(links_);
  links_.erase(std::unique(links_.begin(), links_.end()), links_.end());
}

void Spots::add_pair(const Mechanism& mechanism, int contact, int tip, int core) {
  const LinkShape& with_tips = mechanism.shapes[static_cast<std::size_t>(tip)];
  const LinkShape& with_core = mechanism.shapes[static_cast<std::size_t>(core)];
  const bool core_is_first = mechanism.contact_table.is_first(contact, with_core.surface) &&
                             (with_core.surface != with_tips.surface || core < tip);
  const LinkShape& belt = core_is_first ? with_tips : with_core;
  for (const Tip& at : tips_of(with_tips.is)) {
    Spot& spot = spots_.emplace_back();
    spot.core = core;
    spot.tip = tip;
    spot.core_link = with_core.link;
    spot.tip_link = with_tips.link;
    spot.contact = contact;
    spot.feature = at.feature;
    spot.sign = core_is_first ? 1 : -1;
    spot.X_LS = with_core.X_LS;
    spot.box = *core_of(with_core.is);
    spot.center = with_tips.X_LS.point(at.center);
    spot.radius = at.radius;
    spot.size = std::min(size_of(with_core.is), size_of(with_tips.is));
    spot.R_belt = belt.X_LS.R;
  }
  links_.push_back(with_core.link);
  links_.push_back(with_tips.link);
}

void Spots::read_position(Dynamics& dynamics) {
  dynamics.readings().set_root_poses();
  for (const int link : links_) {
    if (link > 0) poses_[static_cast<std::size_t>(link)] = dynamics.readings().link_pose(link);
  }
}

void Spots::read_motion(Dynamics& dynamics) {
  read_position(dynamics);
  for (const int link : links_) {
    const auto i = static_cast<std::size_t>(link);
    if (link > 0) V_[i] = poses_[i].to_parent(dynamics.readings().link_velocity(link));
    A_[i] = poses_[i].to_parent(dynamics.readings().link_bias_acceleration(link));
  }
}

Spots::Line Spots::line(const Spot& spot) const {
  Line out;
  const Pose3 X_0S = pose(spot.core_link) * spot.X_LS;
  out.x = X_0S.R.transpose() * (pose(spot.tip_link).point(spot.center) - X_0S.p);
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

double Spots::gap(int spot) const {
  const Spot& at = (*this)[spot];
  return line(at).distance - at.box.radius - at.radius;
}

RelativeMotion Spots::motion(int spot) const {
  const auto a = static_cast<std::size_t>((*this)[spot].core_link);
  const auto b = static_cast<std::size_t>((*this)[spot].tip_link);
  return {V_[b] - V_[a], A_[b] - A_[a]};
}

SpotState Spots::state(int spot) const {
  const Spot& at = (*this)[spot];
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
  if (!at.box.half_space && way.distance > 0) out.n_dot += R_0S * (way_dot - out.rate * way.normal) / way.distance;
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
