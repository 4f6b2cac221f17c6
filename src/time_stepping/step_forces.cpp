// SPDX-License-Identifier: BSD-3-Clause
// What TimeStepper remembers of a step: its forces.
#include <algorithm>
#include <limits>

#include "time_stepping/given_friction.h"
#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

// Normal velocities that solutions may miss, relative to the largest velocity, and [natural units of speed]; and of
// the residual that users permit. What jams in heaps is solved to some 1e-4.
constexpr double missed_fraction = 1e-2;
constexpr double missed_speed = 1e-3;
constexpr double missed_tolerances = 10;
// Ratio of the masses of two bodies that touch from which rounding hides the heavy one: how it responds is the last
// five digits of how the light one does, so that no later step finds its impulses either. Below it, what solvers miss
// is shown by their residual.
constexpr double hiding_ratio = 1e11;
// Openings up to this are rounding of gaps, and what solvers leave of velocities [natural units of length].
constexpr double opening_rounding = touch_tolerance / 1000;
// Gap up to which the force of the last step is still said to act at a point, relative to the smallest shape.
constexpr double near_fraction = 0.1;

// Whether two bodies that touch have so unlike masses.
bool hide_masses(const Mechanism& mechanism, const std::vector<NearPoint>& points) {
  const auto mass = [&](int link) { return link < 0 ? 0.0 : mechanism.links[static_cast<std::size_t>(link)].G.m; };
  return std::ranges::any_of(points, [&](const NearPoint& point) {
    const double a = mass(point.link_a), b = mass(point.link_b);
    return a > 0 && b > 0 && std::max(a, b) > hiding_ratio * std::min(a, b);
  });
}

}  // namespace

// By how much curvature opens the gap of a point in a step, as its gaps in the middles of two steps show.
double TimeStepper::opening(double gap, const RememberedContact& before, double h) const {
  // What penetrates is moved apart.
  if (!(state_.step > 0) || std::min(gap, before.gap) < -touch_tolerance) return 0;
  const double opens = gap - before.gap - (state_.step + h) / 2 * before.gap_rate;
  return opens > opening_rounding ? opens : 0;
}

// missed_ <- the worst one, at the speeds free_speeds_ after the step.
void TimeStepper::find_missed(double h) {
  if (!hide_masses(mechanism_, points_)) return;
  const double permitted =
      std::max(missed_speed, std::max(missed_fraction, missed_tolerances * accuracy_.relative) * fastest());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (cones_[i].is_ball) continue;
    const double until_closed = points_[i].gap > touch_tolerance ? 2 * points_[i].gap / h : 0;
    const double speed = -free_speeds_[static_cast<std::size_t>(cones_[i].first)] - until_closed;
    if (speed / permitted > missed_.excess) missed_ = {points_[i].contact, speed, speed / permitted};
  }
}

// The mean force of a point over the step, on the second shape, about the point.
Spatial::Force TimeStepper::force_at(std::size_t i, double h) const {
  const Cone& cone = cones_[i];
  const double* x = x_.data() + cone.first;
  Spatial::Force out;
  if (cone.is_ball) {
    (points_[i].turns ? out.n : out.f) = in_space(cone, frames_[i], x) / h;
    return out;
  }
  (points_[i].turns ? out.n : out.f) = frames_[i].col(0) * (x[0] / h);
  for (int k = 0; k < cone.tangential; ++k) out.f += frames_[i].col(1 + k) * (x[1 + k] / h);
  const double* moment = x + 1 + cone.tangential;
  if (cone.spin > 0) out.n += frames_[i].col(0) * (*moment++ / h);
  for (int k = 0; k < cone.roll; ++k) out.n += frames_[i].col(1 + k) * (moment[k] / h);
  return out;
}

// Adds such a force to `out`, by link, about the origin of the root frame.
void TimeStepper::add_wrench(const NearPoint& point, const Spatial::Force& on_b,
                             std::vector<Spatial::Force>& out) const {
  const Spatial::Force wrench{on_b.n + point.p.cross(on_b.f), on_b.f};
  out[static_cast<std::size_t>(point.link_b)] += wrench;
  out[static_cast<std::size_t>(point.link_a)] -= wrench;
}

void TimeStepper::remember(double h) {
  for (Spatial::Force& wrench : state_.wrenches) wrench = {};
  for (ContactSum& contact : state_.sums) contact = {};
  rows_.speeds(v1_.data(), free_speeds_.data());
  // Solvers leave a part of the largest velocity.
  const double slow = std::max(rest_speed, left_tolerances * velocity_tolerance());
  last_contacts_.swap(state_.contacts);
  state_.contacts.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const NearPoint& point = points_[i];
    const Cone& cone = cones_[i];
    const double* x = x_.data() + cone.first;
    if (!cone.is_ball && !(x[0] > 0)) continue;
    RememberedContact& contact = state_.contacts.emplace_back();
    contact.a = point.a;
    contact.b = point.b;
    contact.feature = point.feature;
    const Spatial::Force on_b = force_at(i, h);
    contact.force = on_b.f;
    contact.moment = on_b.n;
    contact.gap = point.gap;
    if (!cone.is_ball) contact.gap_rate = free_speeds_[static_cast<std::size_t>(cone.first)];
    contact.slides = cone.tangential == 0 || slip(i, free_speeds_).norm() > slow;
    add_wrench(point, on_b, state_.wrenches);
    ContactSum& sum = state_.sums[static_cast<std::size_t>(point.contact)];
    sum.force -= mechanism_.X_W0.R * (point.turns ? contact.moment : contact.force);
    sum.mode = std::max(sum.mode, contact.slides ? 2 : 1);
  }
  // They act on bodies that have moved on since the middle of the step: their lever arms are those of the middle.
  for (std::size_t i = 0; i < state_.wrenches.size() && !points_.empty(); ++i) {
    Spatial::Force& wrench = state_.wrenches[i];
    if (!wrench.f.isZero(0)) wrench.n -= dynamics_.readings().link_pose(static_cast<int>(i)).p.cross(wrench.f);
  }
  const auto same = [](const RememberedContact& a, const RememberedContact& b) {
    return a.key() == b.key() && a.slides == b.slides;
  };
  if (!std::ranges::equal(last_contacts_, state_.contacts, same)) ++changes_;
  state_.step = h;
  joints_.remember(h, v1_.data(), x_.data(), joint_cones(), state_.locks);
  std::ranges::fill(state_.along, 0.0);
  rows_.add_generalized(static_cast<int>(x_.size()) - static_cast<int>(joints_.count()), x_.data(), 1 / h,
                        state_.along.data());
  find_missed(h);
}

void TimeStepper::forget() {
  state_.contacts.clear();
  std::ranges::fill(state_.locks, LockForces{});
  forget_motion();
}

std::vector<ContactForce> TimeStepper::forces() {
  double reach = std::numeric_limits<double>::infinity();
  for (const LinkShape& shape : mechanism_.shapes) reach = std::min(reach, near_fraction * size_of(*shape.is));
  std::vector<ContactForce> out;
  for (const NearPoint& point : finder_.find(dynamics_.readings(), 0, 0, reach)) {
    if (const RememberedContact* const of = state_.find(point))
      out.push_back({point.contact, point.a, point.b, point.p, of->force, of->moment,
                     point.normal.dot(point.turns ? of->moment : of->force)});
  }
  return out;
}

double TimeStepper::gap(int contact) {
  return finder_.smallest_gaps(dynamics_.readings())[static_cast<std::size_t>(contact)];
}

void TimeStepper::serialize(Archive& archive) {
  const int shapes =
      static_cast<int>(mechanism_.shapes.size() + mechanism_.swings.size() + mechanism_.frictions.size());
  state_.serialize(archive, shapes);
  archive.serialize(has_second_);
  if (has_second_) second_.serialize(archive, shapes);
  archive.serialize(solved_.residual);
  archive.serialize_in_range(solved_.iterations, 0, std::numeric_limits<int>::max());
}

}  // namespace gelenk
