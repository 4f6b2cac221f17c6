// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/hidden_touches.h"

#include <algorithm>
#include <array>

#include "collision/contacts.h"
#include "contact_geometry/contact_finder.h"
#include "math/bounds.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

// Of accelerations estimated by the change of velocities in the step: what they may be in between.
constexpr double acceleration_margin = 2;
// Error of interpolated positions, relative to the way that the accelerations cause: where a gap comes as near to zero
// as that, the step is made up to there to see. As for other events (event/step_course.cpp).
constexpr double interpolation_error = 0.05;
// Penetrations of less depth may remain unnoticed [natural units of length]: what touches so slightly leaves with a
// speed that errors of any step change as much.
constexpr double noticed_depth = 1e-8;
// Positions that are looked at in a step; and the fraction of it that must be safe if they do not suffice, for the step
// to be shortened.
constexpr int most_samples = 100;
constexpr double least_fraction = 1. / 8;

// Whether a distance with gaps g0 and g1 at the ends of a time h and a second derivative of at most `acceleration`
// stays positive.
bool bends_little(double g0, double g1, double h, double acceleration) {
  return std::sqrt(g0) + std::sqrt(g1) >= h * std::sqrt(acceleration / 2);
}

// The corners of a shape without round ones, or the centers of its round ones, in its link.
std::vector<Tip> corners_of(const LinkShape& shape) {
  std::vector<Tip> out = tips_of(*shape.is);
  for (Tip& corner : out) corner.center = shape.X_LS.point(corner.center);
  return out;
}

}  // namespace

HiddenTouches::HiddenTouches(const Mechanism& mechanism, Dynamics& dynamics, TouchEquations& touch)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      touch_(touch),
      pairs_(static_cast<std::size_t>(touch.spots().pairs())),
      samples_(most_halvings),
      qdot0_(static_cast<std::size_t>(mechanism.nq)),
      qdot1_(qdot0_.size()),
      q_(qdot0_.size()) {
  const Spots& spots = touch.spots();
  for (int i = 0; i < spots.count(); ++i) {
    const Spot& spot = spots[i];
    Pair& pair = pairs_[static_cast<std::size_t>(spot.pair)];
    pair.core_link = spot.core_link;
    pair.tip_link = spot.tip_link;
    pair.core_center = spot.X_LS.p;
    pair.tip_center = spot.X_tip.p;
    pair.tip_is_smaller = spots.tip_is_smaller(spot.pair);
    if (spot.kind == Spot::Kind::corner || spot.kind == Spot::Kind::edges) {
      if (!pair.is_sharp()) {
        pair.core = corners_of(mechanism.shapes[static_cast<std::size_t>(spot.core)]);
        pair.tip = corners_of(mechanism.shapes[static_cast<std::size_t>(spot.tip)]);
      }
    } else if (spot.box.half_space || spot.kind == Spot::Kind::rim) {
      pair.normal = spot.X_LS.R.col(2);
    } else {
      pair.curvature = std::max(pair.curvature, 1 / (spot.radius + spot.box.radius));
    }
  }
  unsafe_.reserve(pairs_.size());
  for (Sample* sample : {&first_, &last_}) sample->gaps.resize(pairs_.size());
  for (Sample& sample : samples_) sample.gaps.resize(pairs_.size());
}

// Of a pair at the position read last; infinite if it has sharp features and is closed.
void HiddenTouches::gap(int pair, Gap& out) const {
  const Spots& spots = touch_.spots();
  const Spots::Range range = spots.range(pair);
  out.size = unlimited;
  if (range.first == range.last) return;
  const auto mode = [&](int spot) -> const SpotMode& { return touch_.modes()[static_cast<std::size_t>(spot)]; };
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  if (of.is_sharp()) {
    for (int i = range.first; i < range.last; ++i) {
      if (mode(i).closed) return;
    }
    const Pose3& X_core = spots.pose(of.core_link);
    const Pose3& X_tip = spots.pose(of.tip_link);
    out.X = X_core.inverse() * X_tip;
    if (!spots.is_close(range.first)) {
      double rate = 0;  // not used
      out.size = spots.distance(range.first, rate);
      out.n = (out.X.point(of.tip_center) - of.core_center).normalized();
      return;
    }
    const Spot& spot = spots[range.first];
    std::array<ContactPoint, max_contact_points> points;
    const int count = find_contacts(*mechanism_.shapes[static_cast<std::size_t>(spot.core)].is, X_core * spot.X_LS,
                                    *mechanism_.shapes[static_cast<std::size_t>(spot.tip)].is, X_tip * spot.X_tip,
                                    unlimited, points.data());
    for (int k = 0; k < count; ++k) {
      const ContactPoint& point = points[static_cast<std::size_t>(k)];
      if (!(point.gap < out.size)) continue;
      out.size = point.gap;
      out.n = X_core.R.transpose() * point.normal;
    }
    return;
  }
  if (!spots.is_close(range.first)) {
    double rate = 0;  // not used
    out.size = spots.distance(range.first, rate);
    return;
  }
  for (int i = range.first; i < range.last; ++i) {
    if (!mode(i).closed) out.size = std::min(out.size, spots.gap(i) + mode(i).leaves_from);
  }
}

// At an end of the step.
void HiddenTouches::read(int pair, int end) {
  Pair& of = pairs_[static_cast<std::size_t>(pair)];
  const Spots& spots = touch_.spots();
  if (of.moves_tip()) of.tip_at[end] = spots.approach(pair, true);
  if (of.moves_core()) of.core_at[end] = spots.approach(pair, false);
}

// What overlaps already can touch no more: how deep it gets is watched elsewhere (ContactModes::find_penetration).
void HiddenTouches::begin() {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Gap& now = pairs_[i].gaps[0];
    gap(static_cast<int>(i), now);
    if (now.size < -noticed_depth) now.size = unlimited;
    if (now.size < unlimited) read(static_cast<int>(i), 0);
  }
}

// Of what happens across a plane only that along its normal counts. The way of a center that velocities at the ends do
// not explain shows turns within the step; the points of a shape turn with its angular velocity, and where it turns
// about an axis outside, so does the velocity of its center.
HiddenTouches::Bounds HiddenTouches::bound(const Pair& pair, const Spots::Approach& a, const Spots::Approach& b) const {
  const bool is_plane = !pair.normal.isZero(0);
  const auto along = [&](const Eigen::Vector3d& x) { return is_plane ? std::abs(pair.normal.dot(x)) : x.norm(); };
  const auto across = [&](const Eigen::Vector3d& w) { return is_plane ? pair.normal.cross(w).norm() : w.norm(); };
  const auto speed = [&](const Spots::Approach& at) { return along(at.v) + across(at.w) * at.arm; };
  const auto turning = [&](const Spots::Approach& at) { return across(at.w) * (at.w.norm() * at.arm + at.v.norm()); };
  const double change = along(b.v - a.v) + across(b.w - a.w) * a.arm;
  const double unexplained = along(b.p - a.p - h_ / 2 * (a.v + b.v));
  Bounds out;
  out.acceleration = (acceleration_margin * change + 8 * unexplained / h_) / h_ + std::max(turning(a), turning(b));
  out.speed = std::max(speed(a), speed(b)) + h_ / 2 * out.acceleration;
  return out;
}

bool HiddenTouches::is_safe(const Pair& pair, const Gap& a, const Gap& b, double h) const {
  const Bounds& bounds = pair.tip_is_smaller ? pair.tip_bounds : pair.core_bounds;
  const double g0 = std::max(0.0, a.size) + noticed_depth;
  const double g1 = std::max(0.0, b.size) + noticed_depth;
  if (g0 + g1 > h * bounds.speed) return true;
  if (pair.is_sharp()) return stays_apart(pair, a, a, b, h) || stays_apart(pair, b, a, b, h);
  return bends_little(g0, g1, h, bounds.acceleration + pair.curvature * bounds.speed * bounds.speed);
}

// Whether the plane normal to the gap `at`, fixed to one of the shapes, separates them in all of the time h.
bool HiddenTouches::stays_apart(const Pair& pair, const Gap& at, const Gap& a, const Gap& b, double h) {
  const auto separates = [h](const Eigen::Vector3d& normal, const std::vector<Tip>& fixed,
                             const std::vector<Tip>& moving, const Pose3& X0, const Pose3& X1, double acceleration) {
    double plane = -unlimited;
    for (const Tip& corner : fixed) plane = std::max(plane, normal.dot(corner.center) + corner.radius);
    return std::ranges::all_of(moving, [&](const Tip& corner) {
      const double g0 = normal.dot(X0.point(corner.center)) - corner.radius - plane;
      const double g1 = normal.dot(X1.point(corner.center)) - corner.radius - plane;
      return g0 > -noticed_depth && g1 > -noticed_depth &&
             bends_little(std::max(0.0, g0) + noticed_depth, std::max(0.0, g1) + noticed_depth, h, acceleration);
    });
  };
  if (separates(at.n, pair.core, pair.tip, a.X, b.X, pair.tip_bounds.acceleration)) return true;
  const Eigen::Vector3d to_core = -(at.X.R.transpose() * at.n);
  return separates(to_core, pair.tip, pair.core, a.X.inverse(), b.X.inverse(), pair.core_bounds.acceleration);
}

bool HiddenTouches::is_safe(const Sample& a, const Sample& b) const {
  return std::ranges::all_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    return is_safe(pairs_[i], a.gaps[i], b.gaps[i], (b.s - a.s) * h_);
  });
}

double HiddenTouches::find(double t0, const double* y0, double t1, const double* y1) {
  unsafe_.clear();
  h_ = t1 - t0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Pair& pair = pairs_[i];
    if (!(pair.gaps[0].size < unlimited)) continue;
    gap(static_cast<int>(i), pair.gaps[1]);
    if (!(pair.gaps[1].size < unlimited)) continue;
    read(static_cast<int>(i), 1);
    if (pair.moves_tip()) pair.tip_bounds = bound(pair, pair.tip_at[0], pair.tip_at[1]);
    if (pair.moves_core()) pair.core_bounds = bound(pair, pair.core_at[0], pair.core_at[1]);
    const Bounds& bounds = pair.tip_is_smaller ? pair.tip_bounds : pair.core_bounds;
    pair.error_bound = interpolation_error * bounds.acceleration * h_ * h_ / 8;
    if (!is_safe(pair, pair.gaps[0], pair.gaps[1], h_)) unsafe_.push_back(static_cast<int>(i));
  }
  if (unsafe_.empty()) return unlimited;
  q0_ = y0;
  q1_ = y1;
  dynamics_.set_position(y0);
  dynamics_.qdot_from_v(y0, y0 + mechanism_.nq, qdot0_.data());
  dynamics_.qdot_from_v(y1, y1 + mechanism_.nq, qdot1_.data());
  first_.s = 0;
  last_.s = 1;
  for (const int pair : unsafe_) {
    const auto i = static_cast<std::size_t>(pair);
    first_.gaps[i] = pairs_[i].gaps[0];
    last_.gaps[i] = pairs_[i].gaps[1];
  }
  samples_left_ = most_samples;
  const double s = search(first_, last_, 0);
  dynamics_.set_position(y1);
  dynamics_.set_velocity(y1 + mechanism_.nq);
  touch_.spots().read_motion(dynamics_);
  return s < 1 ? t0 + s * h_ : unlimited;
}

// Interpolates the position, and writes the gaps there.
void HiddenTouches::look_at(double s, Sample& out) {
  const double r = 1 - s;
  for (std::size_t k = 0; k < q_.size(); ++k) {
    q_[k] = r * r * (1 + 2 * s) * q0_[k] + s * s * (3 - 2 * s) * q1_[k] + s * r * h_ * (r * qdot0_[k] - s * qdot1_[k]);
  }
  dynamics_.normalize(q_.data());
  dynamics_.set_position(q_.data());
  touch_.spots().read_position(dynamics_);
  out.s = s;
  for (const int pair : unsafe_) gap(pair, out.gaps[static_cast<std::size_t>(pair)]);
}

// Whether something penetrates, or comes so near between a and b that it may.
bool HiddenTouches::may_touch(const Sample& a, const Sample& at, const Sample& b) const {
  return std::ranges::any_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    const double gap = at.gaps[i].size;
    if (gap < -touch_tolerance) return true;
    return gap < a.gaps[i].size && gap < b.gaps[i].size && gap < pairs_[i].error_bound;
  });
}

// Whether nothing is closer at b than at a, but for rounding: what leaves without a speed hardly moves at first.
bool HiddenTouches::separates(const Sample& a, const Sample& b) const {
  return std::ranges::all_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    return b.gaps[i].size > a.gaps[i].size - touch_tolerance;
  });
}

// The first fraction of the step at which something may touch between a and b; 1: nothing does. What has just left is
// so near that bounds of speeds would permit no step; in one of the smallest parts it is seen to continue to leave.
double HiddenTouches::search(const Sample& a, const Sample& b, int halvings) {
  if (is_safe(a, b)) return 1;
  if (samples_left_ == 0) return a.s >= least_fraction ? a.s : 1;
  if (halvings == most_halvings) return separates(a, b) ? 1 : b.s < 1 ? b.s : a.s;
  --samples_left_;
  Sample& middle = samples_[static_cast<std::size_t>(halvings)];
  look_at((a.s + b.s) / 2, middle);
  if (const double s = search(a, middle, halvings + 1); s < 1) return s;
  if (may_touch(a, middle, b)) return middle.s;
  return search(middle, b, halvings + 1);
}

}  // namespace gelenk
