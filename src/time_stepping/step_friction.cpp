// SPDX-License-Identifier: BSD-3-Clause
// Which points of TimeStepper have static friction, and which that of sliding.
#include <cstddef>

#include "kinematics/loads.h"
#include "time_stepping/given_friction.h"
#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

// Cosine of the angle up to which a motion that turns back passes through rest.
constexpr double straight = 0.999;

}  // namespace

// What slid in the last step, or strikes with a tangential speed, has sliding friction.
void TimeStepper::set_friction(double h) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[i].contact)];
    if (law.static_friction == law.sliding_friction) continue;
    const RememberedContact* before = state_.find(points_[i]);
    const bool slides = before != nullptr ? before->slides : slip(i, speeds_).norm() > rest_speed;
    if (slides) set_coefficient(cones_[i], law, h, law.sliding_friction);
  }
}

// Points that would turn back within the step come to rest before, and have static friction; if it does not hold them,
// they slide. Returns whether the friction of any has changed.
bool TimeStepper::stop_turning_points(double h) {
  bool changed = false, has_speeds = false;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[i].contact)];
    if (law.static_friction == law.sliding_friction || turning_[i] == Turning::turns || strikes_[i] != 0) continue;
    const bool was_held = turning_[i] == Turning::may_be_held;
    if (!was_held && !has_coefficient(cones_[i], law, h, law.sliding_friction)) continue;
    if (!has_speeds) rows_.speeds(v1_.data(), after_.data());
    has_speeds = true;
    const Eigen::Vector3d before = slip(i, speeds_), after = slip(i, after_);
    if (was_held) {
      if (after.norm() <= rest_speed) continue;
      turning_[i] = Turning::turns;
    } else {
      if (!(before.dot(after) < -straight * before.norm() * after.norm()) || after.norm() <= rest_speed) continue;
      turning_[i] = Turning::may_be_held;
    }
    set_coefficient(cones_[i], law, h, was_held ? law.sliding_friction : law.static_friction);
    changed = true;
  }
  return changed;
}

// The tangential velocity of the second surface relative to the first at a point. speeds: by row.
Eigen::Vector3d TimeStepper::slip(std::size_t point, const std::vector<double>& speeds) const {
  const Cone& cone = cones_[point];
  if (cone.is_ball) return in_space(cone, frames_[point], speeds.data() + cone.first);
  const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[point].contact)];
  const Eigen::Vector3d belt = finder_.pose(points_[point].b).R * law.belt_velocity;
  Eigen::Vector3d out = belt - belt.dot(points_[point].normal) * points_[point].normal;
  const auto first = static_cast<std::size_t>(cones_[point].first) + 1;
  for (int k = 0; k < cones_[point].tangential; ++k) {
    out += frames_[point].col(1 + k) * speeds[first + static_cast<std::size_t>(k)];
  }
  return out;
}

}  // namespace gelenk
