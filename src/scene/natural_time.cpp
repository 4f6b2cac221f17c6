// SPDX-License-Identifier: BSD-3-Clause
#include "scene/natural_time.h"

#include <algorithm>
#include <cmath>

#include "joint/registry.h"
#include "scene/scene.h"

namespace gelenk {
namespace {

constexpr double usual_time = 16;

// Stiffness over inertia, the smallest [1/s2]; 0: there is no spring.
double softest_spring(const Scene& scene, const UnitSystem& units) {
  double rate = 0;
  const auto add = [&](double stiffness, double inertia) {
    if (stiffness > 0) rate = rate > 0 ? std::min(rate, stiffness / inertia) : stiffness / inertia;
  };
  for (const Joint& joint : scene.joints) {
    const JointKind& kind = *find_joint_kind(joint.type);
    for (std::size_t i = 0; i < joint.stiffness.size(); ++i) {
      add(joint.stiffness[i], kind.v[i].unit == "m/s" ? units.mass : units.mass * units.length * units.length);
    }
  }
  for (const Force& force : scene.forces) add(force.stiffness, units.mass);
  return rate;
}

// Of constant forces: force over mass and length, the largest [1/s2].
double largest_push(const Scene& scene, const UnitSystem& units) {
  double rate = 0;
  for (const Force& force : scene.forces) {
    const double largest = std::max(force.force.norm(), force.torque.norm() / units.length);
    rate = std::max(rate, largest / (units.mass * units.length));
  }
  return rate;
}

}  // namespace

double natural_time(const Scene& scene, const UnitSystem& units) {
  double rate = scene.gravity.norm() / units.length;  // squared [1/s2]
  if (!(rate > 0)) rate = softest_spring(scene, units);
  if (!(rate > 0)) rate = largest_push(scene, units);
  const double time = 1 / std::sqrt(rate);
  const bool usual = !std::isfinite(time) || (time >= 1 / usual_time && time <= usual_time);
  return usual ? 1 : std::exp2(std::round(std::log2(time)));
}

}  // namespace gelenk
