// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/rest_forces.h"

#include "analysis/trial_state.h"
#include "dynamics/distributed_forces.h"
#include "kinematics/switching_force.h"
#include "linear/descent.h"
#include "scene/element_numbers.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Whether nothing accelerates at a pose that has been evaluated. The rounding of stiff springs is known where
// derivatives exist.
bool is_balanced(TrialStates& poses, TrialState& at) {
  if (largest(at.vdot) <= equilibrium_rate_tolerance) return true;
  try {
    poses.differentiate(at);
    return at.is_balanced();
  } catch (const NotDifferentiablePoint&) {
    return false;
  }
}

// What may hold its coordinate at rest: a lock that is engaged, otherwise friction or the contact with a bound.
// contacts: by lock.
std::vector<int> holding_locks(const SwitchingForces& forces, int count, const std::vector<int>& contacts) {
  std::vector<int> out;
  for (int i = 0; i < count; ++i) {
    const bool holds = contacts[static_cast<std::size_t>(i)] != 0 || forces.sticking_limit(i).largest() > 0;
    if (forces.hold_coordinate(i) ? forces.lock(i).latch >= 0 : holds) out.push_back(i);
  }
  return out;
}

// One of the forces along its coordinate.
int force_of(const SwitchingForces::Lock& lock) {
  if (lock.friction >= 0) return lock.friction;
  return lock.limit >= 0 ? lock.limit : lock.latch;
}

std::string name_of(const Joint& joint, const Coordinate& coordinate) {
  return joint.name + "." + std::string(coordinate.name.empty() ? coordinate.speed : coordinate.name);
}

}  // namespace

void RestForces::add(const Scene& scene, const EquilibriumProblem& of, const std::vector<double>& q,
                     const std::vector<double>& cut_q) {
  TrialStates poses(of);
  TrialState at{.q = q, .cut_q = cut_q, .v = std::vector<double>(of.mechanism.nv, 0.0), .u = of.u};
  poses.evaluate(at);
  poses.touch(at);
  poses.hold_friction();
  poses.evaluate(at);
  SwitchingForces& forces = poses.forces();
  at.vdot /= of.time * of.time;
  RestContacts touching = rest_contacts(scene, of, poses.dynamics(), at.vdot.data());
  at.vdot *= of.time * of.time;
  const std::vector<int> locks = holding_locks(forces, poses.locks(), at.contacts);
  const HoldingBounds bounds = holding_bounds(forces, locks, at.contacts);
  DistributedForces distributed;
  const VectorXd& x = distributed.find(forces, locks, at.contacts);
  for (Index i = 0; i < x.size(); ++i) {
    const double slack = forces.slack(locks[static_cast<std::size_t>(i)]);
    is_held = is_held && x[i] <= bounds.upper[i] + slack && x[i] >= bounds.lower[i] - slack;
  }
  is_held = is_held && touching.is_held;
  is_balanced =
      (touching.points.empty() ? gelenk::is_balanced(poses, at) : largest(at.vdot) <= equilibrium_rate_tolerance) &&
      is_balanced;
  contacts.points.insert(contacts.points.end(), touching.points.begin(), touching.points.end());
  contacts.can_push = contacts.can_push && touching.can_push;
  contacts.is_held = contacts.is_held && touching.is_held;
  if (contacts.undefined.empty()) contacts.undefined = touching.undefined;

  const std::vector<SwitchingForce> places = switching_forces_of(of.loads);
  Index next = 0;
  for (int i = 0; i < poses.locks(); ++i) {
    const SwitchingForces::Lock& lock = forces.lock(i);
    const SwitchingForce& at_joint = places[static_cast<std::size_t>(force_of(lock))];
    const Joint& joint = scene.joints[static_cast<std::size_t>(at_joint.joint)];
    const Coordinate coordinate = coordinate_of(kind_of(*joint.is), at_joint.component);
    const std::string unit = unit_of("{f}", coordinate);
    const double size = scene.units.size_of(unit);
    const bool holds = next < x.size() && locks[static_cast<std::size_t>(next)] == i;
    const double x_of_lock = holds ? x[next++] : 0;
    const bool is_latched = forces.hold_coordinate(i);
    if (is_latched && lock.latch < 0) continue;  // its coordinate is held by another one
    coordinates.push_back({.coordinate = name_of(joint, coordinate),
                           .unit = unit,
                           .force = size * x_of_lock,
                           .limit = is_latched ? 0 : size * forces.sticking_limit(i).against(x_of_lock > 0 ? -1 : 1),
                           .side = is_latched ? RestForces::Of::by_lock : at.contacts[static_cast<std::size_t>(i)]});
  }
}

}  // namespace gelenk
