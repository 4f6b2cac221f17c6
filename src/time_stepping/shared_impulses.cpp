// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/shared_impulses.h"

#include <algorithm>
#include <cmath>

#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows for which singular values are found.
constexpr Index most_rows = 80;
// What solvers leave of normal velocities is no motion, relative to the largest.
constexpr double at_rest = 1e-6;

}  // namespace

// What is at rest, by row, and how multipliers act on all rows.
struct SharedImpulses::Kept {
  SharedLoads loads;
  std::vector<Index> rows;
  std::vector<VectorXd> acts;     // by multiplier, on all rows
  std::vector<VectorXd> sliding;  // by motion of what slides: its direction, by row
  std::vector<Index> held;        // by lock: its multiplier

  Index add(Index row, Index count) {
    rows.push_back(row);
    acts.emplace_back(VectorXd::Unit(count, row));
    return static_cast<Index>(rows.size()) - 1;
  }
};

bool SharedImpulses::presses(std::size_t point) const {
  const Cone& cone = of_.cones_[point];
  if (cone.is_ball) return false;
  const auto normal = static_cast<std::size_t>(cone.first);
  const double speed = std::abs(of_.free_speeds_[normal]);
  const bool touches = of_.points_[point].gap <= 2 * touch_tolerance && speed <= at_rest * of_.fastest();
  return of_.x_[normal] > 0 || touches;
}

// Whether the law of a row of a joint keeps it at rest.
bool SharedImpulses::holds(std::size_t joint) const {
  const JointRows::Row& row = of_.joints_[joint];
  const LockForces& at = of_.state_.locks[static_cast<std::size_t>(row.lock)];
  if (row.is_latch) return true;
  const bool acts = of_.x_[static_cast<std::size_t>(of_.cones_[of_.points_.size() + joint].first)] != 0;
  return acts && (row.side == 0 ? at.motion == 0 : at.contact == row.side);
}

bool SharedImpulses::may_share() const {
  if (of_.operator_.dense() == nullptr || of_.strikes_any_ || of_.state_.step == 0) return false;
  if (of_.x_.size() != static_cast<std::size_t>(of_.operator_.size())) return false;
  bool any_point = false, any_joint = false;
  for (std::size_t i = 0; i < of_.points_.size(); ++i)
    any_point = any_point || (of_.cones_[i].tangential > 0 && presses(i));
  for (std::size_t i = 0; i < of_.joints_.count() && any_point; ++i) any_joint = any_joint || holds(i);
  return any_joint;
}

// cones: in, those of joints that hold; out, all that act on what these act on, directly or by others.
void SharedImpulses::keep_connected(std::vector<char>& cones) const {
  const auto n = static_cast<Index>(of_.x_.size());
  const Eigen::Map<const MatrixXd> G(of_.operator_.dense(), n, n);
  const auto block = [&](std::size_t i, std::size_t j) {
    return G.block(of_.cones_[i].first, of_.cones_[j].first, of_.cones_[i].size(), of_.cones_[j].size());
  };
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    if (cones[i] != 0) open.push_back(i);
  }
  while (!open.empty()) {
    const std::size_t from = open.back();
    open.pop_back();
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const bool is_at_rest = i < of_.points_.size() ? presses(i) : holds(i - of_.points_.size());
      if (cones[i] != 0 || !is_at_rest || block(i, from).isZero(0)) continue;
      cones[i] = 1;
      open.push_back(i);
    }
  }
}

void SharedImpulses::add_point(std::size_t point, Kept& to) const {
  const Cone& cone = of_.cones_[point];
  const auto n = static_cast<Index>(of_.x_.size());
  const double slow = std::max(rest_speed, left_tolerances * of_.velocity_tolerance());
  SharedLoads::Point out{.contact = of_.points_[point].contact, .coefficient = cone.friction};
  out.normal = to.add(cone.first, n);
  for (const ConeGroup& group : cone.limited()) {
    if (group.size == 0 || !(group.coefficient > 0)) continue;
    const Index first = cone.first + group.offset;
    VectorXd speed(group.size);
    for (Index k = 0; k < group.size; ++k)
      speed[k] =
          of_.free_speeds_[static_cast<std::size_t>(first + k)] + of_.belts_[static_cast<std::size_t>(first + k)];
    if (speed.norm() > slow) {
      const VectorXd direction = speed / speed.norm();
      VectorXd& acts = to.acts[static_cast<std::size_t>(out.normal)];
      acts.segment(first, group.size) -= group.coefficient * direction;
      to.sliding.emplace_back(VectorXd::Zero(n)).segment(first, group.size) = direction;
      out.slides = true;
      continue;
    }
    const Index at = to.add(first, n);
    for (Index k = 1; k < group.size; ++k) to.add(first + k, n);
    if (group.offset != 1 || cone.tangential == 0) continue;
    out.first = at;
    out.size = group.size;
  }
  to.loads.points.push_back(out);
}

void SharedImpulses::add_joint(std::size_t joint, Kept& to) const {
  const JointRows::Row& row = of_.joints_[joint];
  const auto n = static_cast<Index>(of_.x_.size());
  const auto is_same = [&](int lock) { return lock == row.lock; };
  if (std::ranges::any_of(to.loads.locks, is_same)) return;  // another law of it
  to.held.push_back(to.add(of_.cones_[of_.points_.size() + joint].first, n));
  to.loads.locks.push_back(row.lock);
  to.loads.may.push_back(largest_holding_forces(of_.dynamics_.switching_forces(), row.lock));
}

std::optional<SharedLoad> SharedImpulses::find() const {
  if (!may_share()) return std::nullopt;
  std::vector<char> cones(of_.cones_.size());
  const std::size_t points = of_.points_.size();
  for (std::size_t i = points; i < cones.size(); ++i) cones[i] = holds(i - points) ? 1 : 0;
  keep_connected(cones);
  Kept kept;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    if (cones[i] == 0) continue;
    i < points ? add_point(i, kept) : add_joint(i - points, kept);
  }
  const auto count = static_cast<Index>(kept.rows.size());
  if (count > most_rows || kept.loads.points.empty()) return std::nullopt;
  const auto n = static_cast<Index>(of_.x_.size());
  const Eigen::Map<const MatrixXd> G(of_.operator_.dense(), n, n);
  MatrixXd all(n, count), sliding(static_cast<Index>(kept.sliding.size()), n), at_rest(count, count);
  for (Index k = 0; k < count; ++k) all.col(k) = G * kept.acts[static_cast<std::size_t>(k)];
  for (Index k = 0; k < count; ++k) at_rest.row(k) = all.row(kept.rows[static_cast<std::size_t>(k)]);
  for (Index k = 0; k < sliding.rows(); ++k) sliding.row(k) = kept.sliding[static_cast<std::size_t>(k)];
  SharedLoads& of = kept.loads;
  of.x.resize(count);
  for (Index k = 0; k < count; ++k) {
    const double impulse = of_.x_[static_cast<std::size_t>(kept.rows[static_cast<std::size_t>(k)])];
    of.x[k] = impulse / of_.state_.step;
  }
  of.directions = directions_without_effect(at_rest);
  of.effects = sliding * all * of.directions;
  of.largest_effect = all.cwiseAbs().maxCoeff();
  of.joints.resize(static_cast<Index>(kept.held.size()), of.directions.cols());
  of.held.resize(of.joints.rows());
  for (Index i = 0; i < of.joints.rows(); ++i) {
    const Index at = kept.held[static_cast<std::size_t>(i)];
    of.joints.row(i) = of.directions.row(at);
    const LockForces& forces = of_.state_.locks[static_cast<std::size_t>(of.locks[static_cast<std::size_t>(i)])];
    of.held[i] = forces.friction + forces.limit + forces.latch;
  }
  return find_shared_load(of);
}

}  // namespace gelenk
