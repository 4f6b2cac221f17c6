// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/report.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "assembly/loop_closure.h"

#include "kinematics/switching_force.h"
#include "preparation/doubts.h"
#include "scene/element_numbers.h"
#include "util/text.h"

namespace gelenk {
namespace {

double in_si(const Scene& scene, double x, std::string_view unit) { return x * scene.units.size_of(unit); }
// Returns the permitted closure error [m].
std::string allowed(const Scene& scene) {
  return scene.units.is_si() ? "1e-9" : text::rounded(in_si(scene, assembled_gap, "m"), 3);
}

// Returns the closure error: "0.134 m" or "0.134 m and 0.2 rad".
std::string closure_error_text(const Scene& scene, const CannotAssemble& fault) {
  const std::string meters = text::rounded(in_si(scene, fault.gap, "m"), 3) + " m";
  return fault.turn > assembled_gap ? meters + " and " + text::rounded(fault.turn, 3) + " rad" : meters;
}

std::string prefix(const Scene& scene) { return scene.file.empty() ? "" : scene.file + ": "; }

// Returns " at A.phi = 0.52 rad" with the first scalar coordinate of the loop that belongs to a tree joint.
std::string position_text(const Scene& scene, const ReducedScene& reduced, const std::vector<int>& joints,
                          const std::vector<double>& q) {
  for (const int j : joints) {
    const JointKind& kind = *find_joint_kind(scene.joints[j].type);
    const JointPlace& place = reduced.joints[j];
    if (place.role != JointPlace::Role::tree || kind.nq != 1) continue;
    return " at " + scene.joints[j].name + "." + std::string(kind.q[0].name) + " = " +
           text::rounded(in_si(scene, place.q_sign[0] * q[place.iq], kind.q[0].unit)) + " " +
           std::string(kind.q[0].unit);
  }
  return "";
}

std::string describe_island(const Scene& scene, const ReducedScene& reduced, int island, const Assembled& found) {
  std::string out = "loops closed at";
  const char* separator = " ";
  for (const int j : reduced.islands[island].joints) {
    const JointPlace& place = reduced.joints[j];
    if (place.role != JointPlace::Role::tree) continue;
    const JointKind& kind = *find_joint_kind(scene.joints[j].type);
    if (kind.has_quaternion()) continue;
    for (int i = 0; i < kind.nq; ++i) {
      out += separator + scene.joints[j].name + "." + std::string(kind.q[i].name) + " = " +
             text::rounded(in_si(scene, place.q_sign[i] * found.q[place.iq + i], kind.q[i].unit)) + " " +
             std::string(kind.q[i].unit);
      separator = ", ";
    }
  }
  if (found.moved > 0) out += "; guesses changed by up to " + text::rounded(found.moved);
  if (found.tries > 1)
    out += "; the iteration did not converge from the guesses, but from start " + std::to_string(found.tries);
  return out;
}

constexpr double rounding = 1e-12;  // natural units: of a coordinate whose loops are closed

// A fixed value with the name and sign of the scene.
struct Named {
  int joint = -1;
  std::string name;  // "A.phi"
  std::string unit;
  double sign = 1;
  double fixed = 0;  // given value
};

Named named(const Scene& scene, const ReducedScene& reduced, int island, const FixedValue& value) {
  for (const int j : reduced.islands[island].joints) {
    const JointPlace& place = reduced.joints[j];
    const Joint& joint = scene.joints[j];
    const JointKind& kind = *find_joint_kind(joint.type);
    if (place.role != (value.cut ? JointPlace::Role::cut : JointPlace::Role::tree)) continue;
    if (value.first < place.iv || value.first >= place.iv + kind.nv) continue;
    const bool speed = value.q < 0;
    const int i = speed ? value.first - place.iv : value.q - place.iq;
    const Quantity& quantity = (speed ? kind.v : kind.q)[i];
    const std::string_view name =
        quantity.name.substr(0, value.count > 1 ? quantity.name.find('[') : std::string::npos);
    return {j, joint.name + "." + std::string(name), std::string(quantity.unit),
            (speed ? place.v_sign : place.q_sign)[i], (speed ? joint.start.v : joint.start.q)[i]};
  }
  return {};
}

// Returns "Leave one of them as a guess (fixed: false): D.phi, for instance, would then be 1.83 rad instead of 2 rad."
std::string conflict_advice(const Scene& scene, const Conflict& conflict, const std::vector<Named>& values) {
  const bool one = values.size() == 1;
  std::string out = one ? " Leave it as a guess (fixed: false)" : " Leave one of them as a guess (fixed: false)";
  if (conflict.freed < 0) return out + ".";
  const Named& freed = values[static_cast<std::size_t>(conflict.freed)];
  const auto shown = [&](double x) {
    return text::rounded(std::abs(x) < rounding ? 0 : in_si(scene, x, freed.unit)) + " " + freed.unit;
  };
  return out + (one ? ": it" : ": " + freed.name + ", for instance,") + " would then be " +
         shown(freed.sign * conflict.nearest) + " instead of " + shown(freed.fixed) + ".";
}

std::vector<Named> all_named(const Scene& scene, const ReducedScene& reduced, int island, const Conflict& conflict) {
  std::vector<Named> out;
  for (const FixedValue& value : conflict.values) out.push_back(named(scene, reduced, island, value));
  return out;
}

std::string describe_fixed_speeds(const Scene& scene, const ReducedScene& reduced, int island,
                                  const CannotAssemble& fault) {
  const std::string what = reduced.islands[island].driven() ? "the loops and prescribed motions" : "the loops";
  const std::string left = ": smallest velocity error " + text::rounded(in_si(scene, fault.gap, "m"), 3) +
                           " m/s (rad/s), allowed " + allowed(scene) + ".";
  const std::vector<Named> values = all_named(scene, reduced, island, fault.conflict);
  if (values.empty()) return prefix(scene) + what + " have no consistent start velocities" + left;
  std::vector<std::string> joints;
  for (const Named& value : values) {
    const std::string& name = scene.joints[value.joint].name;
    if (std::ranges::find(joints, name) == joints.end()) joints.push_back(name);
  }
  return prefix(scene) + "the fixed start velocities of " + text::list(joints) + " contradict " + what + left +
         conflict_advice(scene, fault.conflict, values);
}

// Describes the fixed values that prevent a loop from closing.
std::string describe_fixed_positions(const Scene& scene, const std::vector<Named>& values, const Conflict& conflict) {
  std::vector<std::string> names;
  for (const Named& value : values) names.push_back(value.name);
  const std::string what = values.size() == 1 ? "The fixed value of " + names[0] + " contradicts the loops."
                                              : "The fixed values of " + text::list(names) + " contradict each other.";
  return what + conflict_advice(scene, conflict, values);
}

// Returns the owner of a constraint equation: "the loop through C" or "constraints.drive".
std::string owner_of_row(const Scene& scene, const Mechanism& mechanism, int row) {
  for (const Cut& cut : mechanism.cuts) {
    if (row < cut.first_row || row >= cut.first_row + cut.rows) continue;
    return cut.is_contact() ? "constraints." + scene.constraints[cut.constraint].name
                            : "the loop through " + scene.joints[cut.scene_joints.front()].name;
  }
  const CoordinateRow& of = mechanism.coordinate_rows[row - mechanism.first_coordinate_row()];
  return "constraints." + scene.constraints[of.constraint].name;
}

// "forces.rope", or "components.strut" of a force that is part of a component.
std::string path_of_force(const Scene& scene, int force) {
  const Force& of = scene.forces[static_cast<std::size_t>(force)];
  return (of.component.empty() ? "forces." : "components.") + of.name;
}

}  // namespace

std::vector<int> joints_of_loop(const Mechanism& mechanism, int cut) {
  const Cut& c = mechanism.cuts[cut];
  std::set<int> out(c.scene_joints.begin(), c.scene_joints.end());
  for (const int link : c.path_a) out.insert(mechanism.links[link].scene_joint);
  for (const int link : c.path_b) out.insert(mechanism.links[link].scene_joint);
  return {out.begin(), out.end()};
}

std::string describe_assembly(const Scene& scene, const ReducedScene& reduced, const std::vector<Assembled>& found) {
  std::string out;
  for (int i = 0; i < static_cast<int>(reduced.islands.size()); ++i) {
    if (reduced.islands[i].rows == 0) continue;
    out += (out.empty() ? "" : "; ") + describe_island(scene, reduced, i, found[i]);
  }
  return out.empty() ? "no loops: the start values are taken as they are" : out;
}

std::string describe_failure(const Scene& scene, const ReducedScene& reduced, int island, const CannotAssemble& fault) {
  const Mechanism& mechanism = reduced.islands[island];
  if (fault.cut < 0) return describe_fixed_speeds(scene, reduced, island, fault);
  const auto cuts = static_cast<int>(mechanism.cuts.size());
  const bool conflict = !fault.conflict.values.empty();
  const auto blame = [&] {
    return describe_fixed_positions(scene, all_named(scene, reduced, island, fault.conflict), fault.conflict);
  };
  if (fault.cut >= cuts) {
    const Constraint& c = scene.constraints[mechanism.coordinate_rows[fault.cut - cuts].constraint];
    return prefix(scene) + "constraints." + c.name + " cannot be satisfied at the start: smallest error " +
           closure_error_text(scene, fault) + " " + "(allowed " + allowed(scene) + " m). " +
           (conflict ? blame() : "Check the start values of its joints.");
  }
  const std::vector<int> joints = joints_of_loop(mechanism, fault.cut);
  std::vector<std::string> names;
  std::vector<std::string> fixed;
  for (const int j : joints) {
    names.push_back(scene.joints[j].name);
    const auto& flags = scene.joints[j].start.q_fixed;
    if (std::ranges::find(flags, true) != flags.end()) fixed.push_back(scene.joints[j].name);
  }
  const Cut& cut = mechanism.cuts[fault.cut];
  const std::string what = cut.is_contact() ? "constraints." + scene.constraints[cut.constraint].name
                                            : "loop through " + scene.joints[cut.scene_joints.front()].name;
  std::string out = prefix(scene) + what + " cannot be closed: smallest closure error " +
                    closure_error_text(scene, fault) + position_text(scene, reduced, joints, fault.q) + " " +
                    "(allowed " + allowed(scene) + " m). ";
  if (conflict) return out + blame();
  if (const std::string odd = describe_odd_axis(scene, joints); !odd.empty()) return out + odd;
  const std::string what_to_check = fault.turn > assembled_gap ? "positions, axes and rotations" : "positions";
  out += "Check the " + what_to_check + " in joints " + text::list(names);
  std::vector<std::string> motions;
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    const Constraint& c = scene.constraints[row.constraint];
    if (row.moves() && std::ranges::find(names, c.joints.front()) != names.end())
      motions.push_back("constraints." + c.name);
  }
  if (!motions.empty()) out += ", the motion of " + text::list(motions) + " at the start";
  if (!fixed.empty()) out += ", and the fixed start of " + text::list(fixed);
  return out + ".";
}

std::string describe_no_branch(const Scene& scene, const ReducedScene& reduced, int island,
                               const SingularStart& start) {
  const Mechanism& mechanism = reduced.islands[island];
  std::vector<std::string> fixed;
  for (const int j : mechanism.joints) {
    const auto& flags = scene.joints[j].start.v_fixed;
    if (std::ranges::find(flags, true) != flags.end()) fixed.push_back(scene.joints[j].name);
  }
  return prefix(scene) + "the start is a singular configuration of " + owner_of_row(scene, mechanism, start.row) +
         ", where branches of motion meet, and no branch has the fixed start velocities of " + text::list(fixed) +
         ". Leave one of them as a guess (fixed: false), or start near this position.";
}

std::string describe_singular_start(const Scene& scene, const ReducedScene& reduced, int island,
                                    const SingularStart& start) {
  const std::string owner = owner_of_row(scene, reduced.islands[island], start.row);
  std::string out =
      prefix(scene) + "the start is " +
      (start.pivot_fraction < 1e-9 ? "a singular configuration of " + owner
                                   : "close to a singular configuration of " + owner + " (relative pivot " +
                                         text::rounded(start.pivot_fraction, 2) + ")") +
      ", where branches of motion meet: ";
  if (!start.moves) return out + "at rest nothing determines the branch that the motion will take";
  // In a singular configuration the position is accurate to the square root of round-off only.
  const double open =
      std::max(1e-8, std::min(start.pivot_fraction, 2e-16 / (start.pivot_fraction * start.pivot_fraction)));
  return out +
         "the branch nearest to the given start values is used, and the relative error of the velocities is about " +
         text::rounded(open, 1);
}

std::string describe_no_equilibrium(const Scene& scene, const Signal& acceleration, double left) {
  return prefix(scene) +
         "solver.start: found no equilibrium from the start values under the inputs at the start: the largest residual "
         "acceleration is " +
         acceleration.name + " = " + text::rounded(std::abs(left)) + " " + acceleration.unit +
         "; expected start values closer to an equilibrium, or as_given";
}

namespace {

struct LimitedCoordinate {  // on which a force with modes acts
  std::string limit;        // "joints.A.limit.upper"
  Coordinate coordinate;
};

LimitedCoordinate limited(const Scene& scene, const SwitchingForce& of, int side) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(of.joint)];
  return {prefix(scene) + "joints." + joint.name + ".limit." + (side > 0 ? "upper" : "lower"),
          coordinate_of(kind_of(*joint.is), of.component)};
}

}  // namespace

std::string describe_unstoppable(const Scene& scene, const Loads& loads, int indicator) {
  const SwitchingForce of = switching_forces_of(loads)[static_cast<std::size_t>(indicator / 2)];
  if (of.holds_joint) {
    return prefix(scene) + "joints." + scene.joints[static_cast<std::size_t>(of.joint)].name +
           ".lock: found it engaged at the start, where the loops or prescribed motions move the joint, and no force "
           "can stop it; expected it released, or no speed";
  }
  const LimitedCoordinate at = limited(scene, of, indicator % 2 == 0 ? 1 : -1);
  const std::string name(at.coordinate.name);
  return at.limit + ": found a start with " + name + " at it, from which the loops move " + name +
         " beyond it, and no force can stop it; expected another position, or no speed";
}

std::vector<std::string> describe_violated_limits(const Scene& scene, const Loads& loads, Dynamics& dynamics,
                                                  const double* q) {
  const SwitchingForces& forces = dynamics.switching_forces();
  if (forces.locks() == 0) return {};
  dynamics.set_position(q);
  std::vector<std::string> out;
  const std::vector<SwitchingForce> places = switching_forces_of(loads);
  for (int i = 0; i < forces.locks(); ++i) {
    for (const int side : {1, -1}) {
      const SwitchingForces::Depth at = forces.depth(i, side);
      if (!(at.depth > at.tolerance)) continue;
      const SwitchingForce& of = places[static_cast<std::size_t>(forces.lock(i).limit)];
      const LimitedCoordinate limit = limited(scene, of, side);
      const std::string unit = unit_of("{q}", limit.coordinate);
      out.push_back(limit.limit + ": found a start with " + std::string(limit.coordinate.name) + " " +
                    text::with_unit(text::rounded(in_si(scene, at.depth, unit)), unit) +
                    " beyond it, expected one within the limits");
    }
  }
  return out;
}

std::string describe_moving_drive(const Scene& scene, int constraint) {
  return prefix(scene) + "solver.start: found equilibrium while constraints." + scene.constraints[constraint].name +
         " moves its joint at the start; expected a motion that begins at rest, or as_given";
}

std::string describe_undefined_rows(const Scene& scene, const Cut& cut) {
  const ElementFault fault = undefined_start(*cut.joint);
  return prefix(scene) + "constraints." + scene.constraints[cut.constraint].name + ": found " + fault.found +
         "; expected " + fault.expected;
}

std::string describe_massless(const Scene& scene, const std::string& link) {
  return prefix(scene) + "bodies." + link +
         ": moves without inertia: found mass and inertia 0 along a motion of its "
         "joint, expected mass > 0 (kg), or an inertia about the joint's axis > 0 (kg m2), here or on bodies it "
         "carries, or a gear, a rack, a prescribed motion or a loop that couples this motion to one with inertia (a "
         "spring is not sufficient: the body would be where its force is zero, at any velocity)";
}

std::string describe_unreachable_tolerance(const std::string& integrator, double tolerance, double finest) {
  return "solver.tolerance: " + text::rounded(tolerance) + " is below the accuracy that '" + integrator +
         "' can achieve because of round-off: errors will be those of tolerance " + text::rounded(finest) +
         "; for smaller errors use 'erk' or 'dirk'";
}

std::string describe_time_steps(const Scene& scene, const std::string& reason, double accuracy) {
  return "contacts are solved in time steps with an accuracy of " + error_text(accuracy, scene.units.size_of("m")) +
         " each, not at located events, which keep the tolerance: " + reason;
}

std::string describe_event(const EventReport& event) {
  return "t = " + text::rounded(event.time) + " s: " + event.text;
}

std::string describe_lost_inertia(double t, const std::string& link) {
  return "after t = " + text::rounded(t) + " s: the effective inertia of bodies." + link +
         " is no longer positive: the solution diverges (steps too large for the method?), or the body now moves "
         "without inertia";
}

std::string describe_equal_assemblies(const Scene& scene, const std::string& coordinate, double taken, double other) {
  return prefix(scene) + "the loops can be closed in two positions that are equally close to the start values: with " +
         coordinate + " = " + text::rounded(taken) + ", which is used, or with " + text::rounded(other) +
         ". Which one is used may depend on the order of the file. Give " + coordinate +
         " a start value closer to the intended one";
}

std::string describe_collapsed_spring(const Scene& scene, int force) {
  return prefix(scene) + path_of_force(scene, force) +
         ": its ends coincide at the start, so that the direction of its force is undefined";
}

std::string describe_undetermined(const Scene& scene, const NotDifferentiablePoint& fault, double t,
                                  const std::vector<std::string>& states) {
  const std::string when = "t = " + text::rounded(t) + " s: ";
  if (fault.reason() == NotDifferentiablePoint::What::spring) {
    return when + "the ends of " + path_of_force(scene, fault.force()) +
           " coincide, so that the direction of its force is undefined: derivatives do not exist there";
  }
  if (fault.reason() == NotDifferentiablePoint::What::rows) {
    return when + "a loop is in or close to a singular configuration, where branches of motion meet: derivatives do " +
           "not exist there or are inaccurate";
  }
  return when + "the states " + text::list(states) +
         " do not determine the other coordinates here (a loop is at a dead center with respect to them): derivatives "
         "with respect to them do not exist there";
}

std::string describe_exhausted_budget(double t, double end, long evaluations, const std::string& obstacle) {
  const std::string why = obstacle.empty() ? "" : ": " + obstacle;
  return "t = " + text::rounded(t) + " s: the step to " + text::rounded(end) + " s ended here, after " +
         std::to_string(evaluations) + " evaluations (solver.max_evaluations)" + why +
         ". The simulation can continue from the state at t = " + text::number(t) +
         " s. Allow more evaluations, or use shorter steps, a larger solver.tolerance or another solver.integrator.";
}

std::string describe_failed_step(const std::string& cause, double good_time) {
  return cause + ". The state is unchanged at t = " + text::rounded(good_time) +
         " s; the simulation can continue from there.";
}

std::string describe_mode_boundary(const Scene& scene, const Loads& loads, int force, double t) {
  const SwitchingForce of = switching_forces_of(loads)[static_cast<std::size_t>(force)];
  return "t = " + text::rounded(t) + " s: joints." + scene.joints[of.joint].name + "." + std::string(of.group) +
         " is between two modes, or a load on which it depends is zero: derivatives do not exist there";
}

}  // namespace gelenk
