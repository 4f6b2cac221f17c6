// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/sliding_steps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dynamics/contact_rows.h"
#include "dynamics/dynamics.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Part of the time in which a velocity turns, or reaches zero, that a step takes.
constexpr double part_of_turn = 0.5;
// What turns by less than this, relative to its deceleration, comes to rest on a straight line, as far as the direction
// of friction matters when a step extends beyond the stop.
constexpr double straight_fraction = 1e-6;
// Step of an explicit method times the rate at which friction turns what slides: Runge-Kutta methods of order 4 are
// stable up to 2.78.
constexpr double stable_turn = 2.5;
// Of the mobility along the motion: below, nothing moves across it, as in a plane.
constexpr double least_mobility = 1e-9;
// Spinning has an axis, and cannot turn.
constexpr std::array turning_groups = {0, 2};

bool is_slow(const ContactEquations::Entry& entry, int group, const EventSource::SlowSliding& by) {
  const auto g = static_cast<std::size_t>(group);
  if (entry.moving[g] < 0) return false;
  const double speed = entry.slip[g].norm();
  return speed < by.followed_from && speed > std::max(rest_speed, by.directed_from);
}

}  // namespace

bool SlidingSteps::any(const EventSource::SlowSliding& by) const {
  if (equations_.closed().empty() || !equations_.rows().any_moves()) return false;
  return std::ranges::any_of(equations_.rows().entries, [&](const ContactEquations::Entry& entry) {
    return std::ranges::any_of(turning_groups, [&](int group) { return is_slow(entry, group, by); });
  });
}

// Numbers the rows and allocates them.
void SlidingSteps::find(const EventSource::SlowSliding& by) {
  slow_.clear();
  Index count = 0;
  const auto& entries = equations_.rows().entries;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    for (const int group : turning_groups) {
      if (!is_slow(entries[i], group, by)) continue;
      const double normal = std::max(0.0, equations_.last_solution().x[entries[i].first]);
      slow_.push_back({.entry = i,
                       .group = group,
                       .first = count,
                       .across = entries[i].kept(group) - 1,
                       .friction = equations_.coefficient(entries[i].candidate, group, true) * normal});
      count += 1 + slow_.back().across;
    }
  }
  R_.resize(count, equations_.rows().R.cols());
  rates_.resize(count);
}

void SlidingSteps::add_rows(const Slow& of) {
  const ContactEquations::Entry& entry = equations_.rows().entries[of.entry];
  const ContactCandidate& candidate = equations_.candidates()[entry.candidate];
  const bool turns = candidate.group_turns(of.group);
  const RelativeMotion motion = equations_.candidates().motion(entry.candidate);
  const Vector3d along = entry.slip[static_cast<std::size_t>(of.group)].normalized();
  const Vector3d first = of.across == 2 ? Vector3d(along.unitOrthogonal()) : Vector3d(entry.at.n.cross(along));
  const std::array<Vector3d, 3> directions = {along, first, along.cross(first)};
  for (int k = 0; k <= of.across; ++k) {
    const Vector3d& d = directions[static_cast<std::size_t>(k)];
    const Index row = of.first + k;
    dynamics_.switching_forces().contact_rows().row(candidate.core_link, candidate.tip_link, entry.at.p, d, turns,
                                                    R_.row(row).data());
    rates_[row] = d.dot(turns ? motion.A.w : motion.acceleration(entry.at.p, entry.at.p_dot));
  }
}

double SlidingSteps::longest(std::span<const double> vdot, const EventSource::SlowSliding& by) {
  find(by);
  for (const Slow& of : slow_) add_rows(of);
  equations_.respond(R_, Z_);
  rates_ += R_.lazyProduct(Eigen::Map<const VectorXd>(vdot.data(), R_.cols()));
  double stiffness = 0;  // 1/s: sum of the rates at which friction turns what slides
  double fastest = 0;    // 1/s: at which a velocity turns, or decreases
  for (const Slow& of : slow_) {
    const double speed = equations_.rows().entries[of.entry].slip[static_cast<std::size_t>(of.group)].norm();
    double across = 0;
    for (Index k = of.first + 1; k <= of.first + of.across; ++k) across = std::max(across, R_.row(k).dot(Z_.col(k)));
    if (!(across > least_mobility * R_.row(of.first).dot(Z_.col(of.first)))) continue;
    stiffness += of.friction * across / speed;
    const double turning = rates_.segment(of.first + 1, of.across).norm();
    if (turning > straight_fraction * std::abs(rates_[of.first]))
      fastest = std::max({fastest, -rates_[of.first] / speed, turning / speed});
  }
  const double rate = std::max(fastest / part_of_turn, by.is_explicit ? stiffness / stable_turn : 0);
  return rate > 0 ? 1 / rate : INFINITY;
}

}  // namespace gelenk
