// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/rest_forces.h"

#include <limits>

#include "analysis/rest_pose.h"
#include "linear/descent.h"
#include "linear/least_load.h"
#include "scene/element_numbers.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Whether nothing accelerates at a pose that has been evaluated. The rounding of stiff springs is known where
// derivatives exist.
bool is_balanced(RestPoses& poses, RestPose& at) {
  if (largest(at.vdot) <= equilibrium_rate_tolerance) return true;
  try {
    poses.differentiate(at);
    return at.is_balanced();
  } catch (const NotDifferentiablePoint&) {
    return false;
  }
}

}  // namespace

void RestForces::add(const Scene& scene, const EquilibriumProblem& of, const std::vector<double>& q,
                     const std::vector<double>& cut_q) {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  RestPoses poses(of);
  RestPose at{.q = q, .cut_q = cut_q};
  poses.evaluate(at);
  poses.touch(at);
  poses.hold_friction();
  poses.evaluate(at);
  Branching& forces = poses.forces();
  std::vector<int> locks;
  for (int i = 0; i < poses.locks(); ++i) {
    if (at.contacts[static_cast<std::size_t>(i)] != 0 || forces.lock(i).sticking_limit > 0) locks.push_back(i);
  }
  const auto n = static_cast<Index>(locks.size());
  VectorXd x(n);
  VectorXd lower(n);
  VectorXd upper(n);
  for (Index i = 0; i < n; ++i) {
    const int lock = locks[static_cast<std::size_t>(i)];
    const int side = at.contacts[static_cast<std::size_t>(lock)];
    const double limit = forces.lock(lock).sticking_limit;
    x[i] = forces.holding_forces().values()[static_cast<std::size_t>(lock)];
    lower[i] = side > 0 ? -unlimited : -limit;
    upper[i] = side < 0 ? unlimited : limit;
  }
  if (forces.is_redundant()) {
    Eigen::MatrixXd W;
    VectorXd scale;
    forces.compliance(locks, W, scale);
    x = least_load(W, W * x, lower, upper);
  }
  for (Index i = 0; i < n; ++i) {
    const double slack = forces.slack(locks[static_cast<std::size_t>(i)]);
    is_held = is_held && x[i] <= upper[i] + slack && x[i] >= lower[i] - slack;
  }
  is_balanced = gelenk::is_balanced(poses, at) && is_balanced;

  const std::vector<BranchingForce> places = branching_forces(of.loads);
  Index next = 0;
  for (int i = 0; i < poses.locks(); ++i) {
    const Branching::Lock lock = forces.lock(i);
    const BranchingForce& at_joint = places[static_cast<std::size_t>(lock.friction >= 0 ? lock.friction : lock.limit)];
    const Joint& joint = scene.joints[static_cast<std::size_t>(at_joint.joint)];
    const Coordinate coordinate = coordinate_of(kind_of(joint.is), at_joint.component);
    const std::string unit = unit_of("{f}", coordinate);
    const double size = scene.units.size_of(unit);
    const bool holds = next < n && locks[static_cast<std::size_t>(next)] == i;
    coordinates.push_back({.coordinate = joint.name + "." + std::string(coordinate.name),
                           .unit = unit,
                           .force = holds ? size * x[next++] : 0,
                           .limit = size * lock.sticking_limit,
                           .side = at.contacts[static_cast<std::size_t>(i)]});
  }
}

}  // namespace gelenk
