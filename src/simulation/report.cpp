// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/report.h"

#include <algorithm>

#include "scene/text.h"

namespace gelenk {
namespace {

std::string prefix(const Scene& scene) { return scene.file.empty() ? "" : scene.file + ": "; }

// " at A.phi = 0.52 rad": the first scalar coordinate of the loop that sits in the tree.
std::string position_text(const Scene& scene, const ReducedScene& reduced, const std::vector<int>& joints,
                          const std::vector<double>& q) {
  for (const int j : joints) {
    const JointKind& kind = *find_joint_kind(scene.joints[j].type);
    const JointPlace& place = reduced.joints[j];
    if (place.role != JointPlace::Role::tree || kind.nq != 1) continue;
    return " at " + scene.joints[j].name + "." + std::string(kind.q[0].name) + " = " +
           text::rounded(place.q_sign[0] * q[place.iq]) + " " + std::string(kind.q[0].unit);
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
             text::rounded(place.q_sign[i] * found.q[place.iq + i]) + " " + std::string(kind.q[i].unit);
      separator = ", ";
    }
  }
  if (found.moved > 0) out += "; guesses moved by up to " + text::rounded(found.moved);
  if (found.tries > 1) out += "; the guesses themselves led nowhere, start " + std::to_string(found.tries) + " did";
  return out;
}

}  // namespace

std::vector<int> joints_of_loop(const Mechanism& mechanism, int cut) {
  const Cut& c = mechanism.cuts[cut];
  std::vector<int> out = c.scene_joints;
  for (const int link : c.path_a) out.push_back(mechanism.links[link].scene_joint);
  for (const int link : c.path_b) out.push_back(mechanism.links[link].scene_joint);
  std::ranges::sort(out);
  return out;
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
  if (fault.cut < 0) {
    std::vector<std::string> fixed;
    for (const Joint& joint : scene.joints) {
      if (std::ranges::find(joint.start.v_fixed, true) != joint.start.v_fixed.end()) fixed.push_back(joint.name);
    }
    return prefix(scene) + "the fixed start speeds of " + text::list(fixed) +
           " contradict the loops: at best a rate of " + fault.what() +
           " m/s (rad/s) is left (allowed 1e-9). Fix fewer speeds, or give them as guesses (fixed: false).";
  }
  const auto cuts = static_cast<int>(mechanism.cuts.size());
  if (fault.cut >= cuts) {
    const Constraint& c = scene.constraints[mechanism.coordinate_rows[fault.cut - cuts].constraint];
    return prefix(scene) + "constraints." + c.name + " cannot be met at the start: smallest gap " + fault.what() +
           " (allowed 1e-9 m). Check the fixed start values of the joints it names.";
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
  std::string out = prefix(scene) + what + " cannot be closed: smallest gap " + fault.what() +
                    position_text(scene, reduced, joints, fault.q) +
                    " (allowed 1e-9 m). Check the positions in joints " + text::list(names);
  if (!fixed.empty()) out += ", and the fixed start of " + text::list(fixed);
  return out + ".";
}

std::string describe_flat_wheel(const Scene& scene, int constraint) {
  return prefix(scene) + "constraints." + scene.constraints[constraint].name +
         ": found the wheel flat on its plane at the start, where it has no point of contact; expected it upright or "
         "tilted: check its axis and the start values of the joints that carry it";
}

std::string describe_massless(const Scene& scene, const std::string& link) {
  return prefix(scene) + "bodies." + link +
         ": moves without inertia: found mass and inertia 0 along a motion of its "
         "joint, expected mass > 0 (kg), or an inertia about the joint's axis > 0 (kg m2), here or on bodies it "
         "carries";
}

std::string describe_singular_position(double t) {
  return "t = " + text::rounded(t) + " s: passed a singular position, where loops could go on by another branch";
}

std::string describe_lost_inertia(double t, const std::string& link) {
  return "after t = " + text::rounded(t) + " s: the inertia seen at bodies." + link +
         " is no longer positive: the motion has grown beyond bounds (steps too long for the method?), or the body has "
         "come to move without inertia";
}

std::string describe_undetermined(Undetermined::What what, double t, const std::vector<std::string>& states) {
  const std::string when = "t = " + text::rounded(t) + " s: ";
  if (what == Undetermined::What::rows) {
    return when +
           "a loop stands in a singular position, where it could go on by another branch: derivatives do not "
           "exist there";
  }
  return when + "the states " + text::list(states) +
         " do not determine the other coordinates here (a loop stands at a dead centre for them): derivatives by them "
         "do not exist there";
}

std::string describe_cut_short(double t, double end, long evaluations) {
  return "t = " + text::rounded(t) + " s: the step to " + text::rounded(end) + " s was left here, with " +
         std::to_string(evaluations) +
         " evaluations (solver.max_evaluations). The plant stands at t = " + text::number(t) +
         " s and can go on from there. Allow more evaluations, or ask for shorter steps, a looser "
         "solver.tolerance or another solver.integrator.";
}

std::string describe_refusal(const std::string& cause, double good_time) {
  return cause + ". The plant still stands at t = " + text::rounded(good_time) + " s and can go on from there.";
}

}  // namespace gelenk
