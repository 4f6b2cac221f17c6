// SPDX-License-Identifier: BSD-3-Clause
#include "contact_geometry/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/convex.h"
#include "mechanism/touching.h"

namespace gelenk {
namespace {

// Swings that are nearer to their limit than this are points of a step in any case: in it, torques that are not known
// yet may turn them as far [rad].
constexpr double near_angle = 0.1;
// Axes at a smaller sine of their angle have no normal.
constexpr double no_normal = 1e-9;

}  // namespace

ContactFinder::ContactFinder(const Mechanism& mechanism, std::size_t contacts)
    : mechanism_(mechanism),
      poses_(mechanism.shapes.size() + mechanism.swings.size()),
      reach_(mechanism.shapes.size()),
      boxes_(mechanism.shapes.size()),
      gaps_(contacts),
      gap_poses_(poses_.size()) {
  // The first body of a kind allocates what all share.
  for (const LinkShape& shape : mechanism.shapes)
    if (kind_of(*shape.is).bounded) ConvexBody(*shape.is, shape.X_LS);
}

int ContactFinder::contact_of(int a, int b) const {
  const auto& shapes = mechanism_.shapes;
  return contact_between(mechanism_.contact_table, shapes[static_cast<std::size_t>(a)],
                         shapes[static_cast<std::size_t>(b)]);
}

void ContactFinder::place(const Readings<double>& readings) {
  for (std::size_t i = 0; i < mechanism_.shapes.size(); ++i) {
    const LinkShape& shape = mechanism_.shapes[i];
    poses_[i] = shape.link == 0 ? shape.X_LS : readings.link_pose(shape.link) * shape.X_LS;
  }
  // Of a swing, on which its angle depends: how one link is turned in the other.
  for (std::size_t i = 0; i < mechanism_.swings.size(); ++i) {
    const Swing& swing = mechanism_.swings[i];
    const auto turned = [&](int link) {
      return link == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : Eigen::Matrix3d(readings.link_pose(link).R);
    };
    poses_[mechanism_.shapes.size() + i].R = turned(swing.link_a).transpose() * turned(swing.link_b);
  }
}

ContactFinder::Found ContactFinder::points_of(int& a, int& b) const {
  Found out;
  out.contact = contact_of(a, b);
  if (out.contact < 0) return out;
  const auto& shapes = mechanism_.shapes;
  if (!mechanism_.contact_table.is_first(out.contact, shapes[static_cast<std::size_t>(a)].surface)) std::swap(a, b);
  const auto i = static_cast<std::size_t>(a);
  const auto j = static_cast<std::size_t>(b);
  const double reach = reach_[i] + reach_[j];
  out.count = find_contacts(*shapes[i].is, poses_[i], *shapes[j].is, poses_[j], reach, out.points.data());
  return out;
}

double ContactFinder::size(int shape) const {
  const auto i = static_cast<std::size_t>(shape);
  return i < mechanism_.shapes.size() ? size_of(*mechanism_.shapes[i].is) : 1;
}

// The angle itself is the gap, since the row of a step is of unit length.
NearPoint ContactFinder::swing_point(const Readings<double>& readings, std::size_t i) const {
  const Swing& swing = mechanism_.swings[i];
  const auto in_root = [&](int link, const Eigen::Vector3d& axis) {
    return link == 0 ? axis : Eigen::Vector3d(readings.link_pose(link).R * axis);
  };
  const Eigen::Vector3d a = in_root(swing.link_a, swing.axis_a);
  const Eigen::Vector3d b = in_root(swing.link_b, swing.axis_b);
  const Eigen::Vector3d c = b.cross(a);
  NearPoint out;
  out.a = out.b = static_cast<int>(mechanism_.shapes.size() + i);
  out.link_a = swing.link_a;
  out.link_b = swing.link_b;
  out.turns = true;
  out.contact = swing.contact;
  out.normal = c.norm() > no_normal ? Eigen::Vector3d(c.normalized()) : a.unitOrthogonal();
  out.gap = swing.angle - std::atan2(c.norm(), a.dot(b));
  return out;
}

NearPoint ContactFinder::friction_point(const Readings<double>& readings, std::size_t i) const {
  const LinkFriction& friction = mechanism_.frictions[i];
  const auto pose = [&](int link) { return link == 0 ? Pose3{} : readings.link_pose(link); };
  NearPoint out;
  out.a = out.b = static_cast<int>(mechanism_.shapes.size() + mechanism_.swings.size() + i);
  out.link_a = friction.link_a;
  out.link_b = friction.link_b;
  out.turns = friction.turns;
  out.given = friction.dimension;
  out.contact = friction.contact;
  out.p = pose(friction.link_b).point(friction.p_b);
  out.normal = pose(friction.link_a).R * friction.R_a.col(2);
  return out;
}

const std::vector<NearPoint>& ContactFinder::find(const Readings<double>& readings, double time, double speed,
                                                  double distance) {
  place(readings);
  for (std::size_t i = 0; i < mechanism_.shapes.size(); ++i) {
    const LinkShape& shape = mechanism_.shapes[i];
    reach_[i] = distance;
    if (shape.link != 0) {
      const Spatial::Motion V = readings.link_velocity(shape.link);
      const double arm = shape.X_LS.p.norm() + size_of(*shape.is);
      reach_[i] += time * (speed + V.v.norm() + V.w.norm() * arm);
    }
    boxes_[i] = bounds(*shape.is, poses_[i]).grown(reach_[i]);
  }
  points_.clear();
  for (auto [a, b] : broad_phase_.pairs(boxes_)) {
    const Found found = points_of(a, b);
    for (int k = 0; k < found.count; ++k) {
      const ContactPoint& at = found.points[static_cast<std::size_t>(k)];
      points_.push_back({.a = a,
                         .b = b,
                         .link_a = mechanism_.shapes[static_cast<std::size_t>(a)].link,
                         .link_b = mechanism_.shapes[static_cast<std::size_t>(b)].link,
                         .turns = false,
                         .given = 0,
                         .contact = found.contact,
                         .p = at.p,
                         .normal = at.normal,
                         .gap = at.gap,
                         .feature = at.feature});
    }
  }
  for (std::size_t i = 0; i < mechanism_.swings.size(); ++i) {
    const auto turning = [&](int link) { return link == 0 ? 0 : readings.link_velocity(link).w.norm(); };
    const NearPoint point = swing_point(readings, i);
    const double turned = time * (turning(point.link_a) + turning(point.link_b));
    if (point.gap <= near_angle + distance + 2 * turned) points_.push_back(point);
  }
  for (std::size_t i = 0; i < mechanism_.frictions.size(); ++i) points_.push_back(friction_point(readings, i));
  std::ranges::sort(points_, {}, &NearPoint::key);
  return points_;
}

const std::vector<double>& ContactFinder::smallest_gaps(const Readings<double>& readings) {
  place(readings);
  const auto same = [](const Pose3& a, const Pose3& b) { return a.R == b.R && a.p == b.p; };
  if (has_gaps_ && std::ranges::equal(poses_, gap_poses_, same)) return gaps_;
  std::ranges::copy(poses_, gap_poses_.begin());
  has_gaps_ = true;
  std::ranges::fill(gaps_, std::numeric_limits<double>::infinity());
  std::ranges::fill(reach_, std::numeric_limits<double>::infinity());
  for (int i = 0; i < static_cast<int>(mechanism_.shapes.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(mechanism_.shapes.size()); ++j) {
      int a = i;
      int b = j;
      const Found found = points_of(a, b);
      for (int k = 0; k < found.count; ++k) {
        double& gap = gaps_[static_cast<std::size_t>(found.contact)];
        gap = std::min(gap, found.points[static_cast<std::size_t>(k)].gap);
      }
    }
  }
  for (std::size_t i = 0; i < mechanism_.swings.size(); ++i) {
    const NearPoint point = swing_point(readings, i);
    gaps_[static_cast<std::size_t>(point.contact)] = point.gap;
  }
  return gaps_;
}

int closed_contact(const Mechanism& mechanism, const Readings<double>& readings, std::size_t contacts) {
  if (!mechanism.touches()) return -1;
  ContactFinder finder(mechanism, contacts);
  const std::vector<double>& gaps = finder.smallest_gaps(readings);
  const auto closed = std::ranges::find_if(gaps, [](double gap) { return gap <= touch_tolerance; });
  return closed == gaps.end() ? -1 : static_cast<int>(closed - gaps.begin());
}

Eigen::Matrix3d contact_axes(const Eigen::Vector3d& n) {
  Eigen::Matrix3d out = rotation_taking_z_to(n);
  const Eigen::Vector3d z = out.col(2);
  out.col(2) = out.col(1);
  out.col(1) = out.col(0);
  out.col(0) = z;
  return out;
}

}  // namespace gelenk
