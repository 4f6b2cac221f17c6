// SPDX-License-Identifier: BSD-3-Clause
// What belts, gaps and the laws of restitution demand of the velocities at the end of a step of TimeStepper.
#include <algorithm>

#include "kinematics/loads.h"
#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {

void TimeStepper::set_belts() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[i].contact)];
    if (law.belt_velocity.isZero(0) || cones_[i].is_ball) continue;
    const Eigen::Vector3d belt = finder_.pose(points_[i].b).R * law.belt_velocity;
    const auto first = static_cast<std::size_t>(cones_[i].first) + 1;
    for (int k = 0; k < cones_[i].tangential; ++k)
      belts_[first + static_cast<std::size_t>(k)] = frames_[i].col(1 + k).dot(belt);
  }
}

// b_ <- the velocities without impulses, plus those that the laws demand. Without restitution, what is reached closes
// its gap at the end of the step. What persists on curved surfaces is apart in the middle of each step, where it
// touches at its ends: by a quarter of what curvature opens in a step. It is given the velocity that leads from its
// present gap to that one; if each gap were closed at the end of its step, every other one would be closed twice, and
// forces would alternate.
void TimeStepper::set_velocities(double h) {
  rows_.speeds(v1_.data(), free_speeds_.data());
  for (std::size_t r = 0; r < b_.size(); ++r) b_[r] = free_speeds_[r] += belts_[r];
  restitution_.add_demands(b_.data());
  add_gaps(h);
  if (!has_compression_) return;
  std::ranges::fill(least_, 0.0);
  restitution_.set_least_impulses(compression_.data(), least_.data());
  operator_.apply(least_.data(), after_.data());
  for (std::size_t r = 0; r < b_.size(); ++r) b_[r] += after_[r];
}

// Adds to b_ what the gaps of points and limits that do not take part in an impact demand.
void TimeStepper::add_gaps(double h) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto r = static_cast<std::size_t>(cones_[i].first);
    if (strikes_[i] != 0) continue;
    if (opens_[i] > 0) {
      constexpr double at_ends = 0.75;
      b_[r] += std::max(0.0, points_[i].gap + at_ends * opens_[i]) / h;
    } else if (points_[i].gap > touch_tolerance) {
      b_[r] += 2 * points_[i].gap / h;
    }
  }
  for (std::size_t i = 0; i < joints_.count(); ++i) {
    const JointRows::Row& row = joints_[i];
    const std::size_t cone = points_.size() + i;
    if (row.side == 0 || strikes_[cone] != 0 || -row.depth <= touch_tolerance) continue;
    b_[static_cast<std::size_t>(cones_[cone].first)] += row.side * 2 * row.depth / h;
  }
}

}  // namespace gelenk
