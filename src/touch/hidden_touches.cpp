// SPDX-License-Identifier: BSD-3-Clause
#include "touch/hidden_touches.h"

#include <algorithm>
#include <array>
#include <limits>

#include "collision/contacts.h"
#include "contact/contact_finder.h"

namespace gelenk {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

// Of accelerations estimated by the change of velocities in the step: what they may be in between.
constexpr double acceleration_margin = 2;
// Error of interpolated positions, relative to the way that the accelerations cause: where a gap comes as near to zero
// as that, the step is made up to there to see. As for other events (event/step_course.cpp).
constexpr double interpolation_error = 0.05;
// Penetrations of less depth may remain unnoticed [natural units of length]: what touches so slightly leaves with a
// speed that errors of any step change as much.
constexpr double least_depth = 1e-8;
// Positions that are looked at in a step; and the fraction of it that must be safe if they do not suffice, for the step
// to be shortened.
constexpr int most_samples = 100;
constexpr double least_fraction = 1. / 8;

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
    if (spot.kind == Spot::Kind::corner || spot.kind == Spot::Kind::edges) pair.is_sharp = true;
    const double radius = spot.radius + spot.box.radius;
    const bool is_plane = spot.box.half_space || spot.kind == Spot::Kind::rim;
    if (is_plane) {
      pair.normal = spot.X_LS.R.col(2);
    } else if (!pair.is_sharp) {
      pair.curvature = std::max(pair.curvature, 1 / radius);
    }
  }
  unsafe_.reserve(pairs_.size());
  for (Sample* sample : {&first_, &last_}) sample->gaps.resize(pairs_.size());
  for (Sample& sample : samples_) sample.gaps.resize(pairs_.size());
}

// Of a pair at the position read last; infinite if it has sharp features and is closed.
double HiddenTouches::gap(int pair) const {
  const Spots& spots = touch_.spots();
  const Spots::Range range = spots.range(pair);
  if (range.first == range.last) return unlimited;
  const auto mode = [&](int spot) -> const SpotMode& { return touch_.modes()[static_cast<std::size_t>(spot)]; };
  double rate = 0;  // not used
  if (!spots.is_close(range.first)) return spots.distance(range.first, rate);
  double out = unlimited;
  if (pairs_[static_cast<std::size_t>(pair)].is_sharp) {
    for (int i = range.first; i < range.last; ++i) {
      if (mode(i).closed) return unlimited;
    }
    const Spot& spot = spots[range.first];
    std::array<ContactPoint, max_contact_points> points;
    const int count =
        find_contacts(mechanism_.shapes[static_cast<std::size_t>(spot.core)].is, spots.pose(spot.core_link) * spot.X_LS,
                      mechanism_.shapes[static_cast<std::size_t>(spot.tip)].is, spots.pose(spot.tip_link) * spot.X_tip,
                      unlimited, points.data());
    for (int k = 0; k < count; ++k) out = std::min(out, points[static_cast<std::size_t>(k)].gap);
    return out;
  }
  for (int i = range.first; i < range.last; ++i) {
    if (!mode(i).closed) out = std::min(out, spots.gap(i) + mode(i).leaves_from);
  }
  return out;
}

// What overlaps already can touch no more: how deep it gets is watched elsewhere (TouchModes::find_penetration).
void HiddenTouches::begin() {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const double now = gap(static_cast<int>(i));
    pairs_[i].gaps[0] = now < -least_depth ? unlimited : now;
    pairs_[i].at[0] = touch_.spots().approach(static_cast<int>(i));
  }
}

// Of what happens across a plane only that along its normal counts. The way of a center that velocities at the ends do
// not explain shows turns within the step; the points of a shape turn with its angular velocity, and where it turns
// about an axis outside, so does the velocity of its center.
void HiddenTouches::bound(Pair& pair, double h) const {
  const Spots::Approach& a = pair.at[0];
  const Spots::Approach& b = pair.at[1];
  const bool is_plane = !pair.normal.isZero(0);
  const auto along = [&](const Eigen::Vector3d& x) { return is_plane ? std::abs(pair.normal.dot(x)) : x.norm(); };
  const auto across = [&](const Eigen::Vector3d& w) { return is_plane ? pair.normal.cross(w).norm() : w.norm(); };
  const auto speed = [&](const Spots::Approach& at) { return along(at.v) + across(at.w) * at.arm; };
  const auto turning = [&](const Spots::Approach& at) { return across(at.w) * (at.w.norm() * at.arm + at.v.norm()); };
  const double change = along(b.v - a.v) + across(b.w - a.w) * a.arm;
  const double unexplained = along(b.p - a.p - h / 2 * (a.v + b.v));
  const double smooth = (acceleration_margin * change + 8 * unexplained / h) / h + std::max(turning(a), turning(b));
  pair.speed = std::max(speed(a), speed(b)) + h / 2 * smooth;
  pair.acceleration = smooth + pair.curvature * pair.speed * pair.speed;
  pair.error_bound = interpolation_error * smooth * h * h / 8;
}

bool HiddenTouches::is_safe(const Pair& pair, double g0, double g1, double h) const {
  const double a = std::max(0.0, g0) + least_depth;
  const double b = std::max(0.0, g1) + least_depth;
  if (a + b > h * pair.speed) return true;
  return !pair.is_sharp && std::sqrt(a) + std::sqrt(b) >= h * std::sqrt(pair.acceleration / 2);
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
    if (!(pair.gaps[0] < unlimited)) continue;
    pair.gaps[1] = gap(static_cast<int>(i));
    if (!(pair.gaps[1] < unlimited)) continue;
    pair.at[1] = touch_.spots().approach(static_cast<int>(i));
    bound(pair, h_);
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
  for (const int pair : unsafe_) out.gaps[static_cast<std::size_t>(pair)] = gap(pair);
}

// Whether something penetrates, or comes so near between a and b that it may.
bool HiddenTouches::may_touch(const Sample& a, const Sample& at, const Sample& b) const {
  return std::ranges::any_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    const double gap = at.gaps[i];
    if (gap < -touch_tolerance) return true;
    return gap < a.gaps[i] && gap < b.gaps[i] && gap < pairs_[i].error_bound;
  });
}

// Whether nothing is closer at b than at a, but for rounding: what leaves without a speed hardly moves at first.
bool HiddenTouches::separates(const Sample& a, const Sample& b) const {
  return std::ranges::all_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    return b.gaps[i] > a.gaps[i] - touch_tolerance;
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
