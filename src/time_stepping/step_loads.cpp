// SPDX-License-Identifier: BSD-3-Clause
// Friction of joints that depends on the forces of bearings, guides and gears, which depend on it, in steps of
// TimeStepper: a fixed point of its limits, which those forces determine as they act with it, on average over the step.
#include <algorithm>
#include <cmath>

#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

// Iterations for the limits, and the relative change at which they end: far below what a step misses.
constexpr int most_load_iterations = 60;
constexpr double load_tolerance = 1e-10;
constexpr const char* undetermined_loads =
    "the friction of a joint depends so much on the load of its bearing, guide or gear that no motion, or more than "
    "one, agrees with it";

}  // namespace

// Solves the equations of motion with the mean impulses x_ of the step as forces, which brings loads to them. Impulses
// of impacts are left out: friction of joints exerts none in return.
void TimeStepper::apply_mean_forces(double h, const double* u) {
  std::ranges::fill(load_along_, 0.0);
  load_x_ = x_;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    if (strikes_[i] == 0) continue;
    std::fill_n(load_x_.begin() + cones_[i].first, cones_[i].size(), 0.0);
  }
  rows_.add_generalized(static_cast<int>(x_.size()) - static_cast<int>(joints_.count()), load_x_.data(), 1 / h,
                        load_along_.data());
  const bool has_shapes = !mechanism_.shapes.empty();
  if (has_shapes) {
    std::ranges::fill(load_wrenches_, Spatial::Force{});
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (strikes_[i] == 0) add_wrench(points_[i], force_at(i, h), load_wrenches_);
    }
  }
  rows_.apply_forces(has_shapes ? load_wrenches_.data() : nullptr, load_along_.data());
  dynamics_.solve(u, load_vdot_.data());
  rows_.apply_forces(nullptr, nullptr);
}

// After respond_to_smooth_forces(): repeats it with the friction that follows from its forces, until both agree.
bool TimeStepper::settle_loads(double h, const double* u) {
  load_along_.resize(v0_.size());
  load_vdot_.resize(v0_.size());
  load_wrenches_.resize(mechanism_.links.size());
  joints_.read_limits(limits_);
  const auto n = static_cast<Eigen::Index>(limits_.size());
  loads_iteration_.start(n);
  for (int k = 0; k < most_load_iterations; ++k) {
    apply_mean_forces(h, u);
    joints_.find_limits(vm_.data(), limits_found_);
    double change = 0, largest = 0;
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      change = std::max(change, std::abs(limits_found_[i] - limits_[i]));
      largest = std::max(largest, std::abs(limits_found_[i]));
    }
    if (!std::isfinite(change)) break;
    if (change <= load_tolerance * largest) return true;
    const Eigen::Map<Eigen::VectorXd> now(limits_.data(), n);
    const Eigen::Map<const Eigen::VectorXd> found(limits_found_.data(), n);
    const AndersonAcceleration::Vector& next = loads_iteration_.next(now, found);
    std::copy_n(next.data(), limits_.size(), limits_.begin());
    joints_.set_limits(h, limits_.data(), joint_cones());
    if (!respond_to_smooth_forces(h)) break;
  }
  failure_ = undetermined_loads;
  return false;
}

}  // namespace gelenk
