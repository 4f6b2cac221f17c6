// SPDX-License-Identifier: BSD-3-Clause
#include "util/synonyms.h"

#include <algorithm>
#include <utility>

#include "util/text.h"

namespace gelenk {
namespace {

// The word of scene files, and those of URDF, MJCF, SDF, Modelica, Simscape, Adams and textbooks for the same thing.
constexpr std::pair<std::string_view, Words> synonyms[] = {
    {"revolute", "hinge pin rotational rotary rotation continuous turning"},
    {"prismatic", "slide slider sliding linear translational translation"},
    {"spherical", "ball ball_socket ballsocket socket ball_and_socket"},
    {"weld", "fixed rigid welded"},
    {"free", "floating freejoint 6dof freeflyer free_flyer"},
    {"universal", "cardan hooke u_joint"},
    {"spring_damper", "spring damper spring-damper springdamper tsda"},
    {"motion", "driver actuator prescribed"},
    {"ground", "world base earth fixed root frame inertial"},
    {"bodies", "links link parts part body segments"},
    {"joints", "joint connections"},
    {"motors", "actuators actuator drives inputs"},
    {"forces", "springs dampers loads force_elements"},
    {"experiment", "simulation run"},
    {"solver", "options"},
    {"gravity", "g"},
    {"mass", "m weight"},
    {"com", "cog cg cm center_of_mass centre_of_mass center_of_gravity centroid r_CM"},
    {"inertia", "i j moi moments moments_of_inertia moment_of_inertia inertia_tensor"},
    {"position", "pos xyz origin location translation"},
    {"rotation", "orientation quaternion rpy euler matrix"},
    {"quaternion", "quat"},
    {"limit", "limits range bounds hardstop hard_stop"},
    {"stop", "endstop end_stop bumpstop"},
    {"lower", "min minimum phi_min s_min low"},
    {"upper", "max maximum phi_max s_max high"},
    {"start", "initial init initial_condition initial_conditions q0 ref"},
    {"phi", "angle theta q position pos"},
    {"s", "q position pos x"},
    {"w", "omega phidot phi_dot qdot qd speed velocity"},
    {"v", "sdot s_dot qdot qd speed velocity"},
    {"damping", "damper d c viscous_friction"},
    {"stiffness", "spring k c"},
    {"length", "rest_length free_length unstretched_length s_unstretched l0"},
    {"parent", "body1 predecessor frame_a base"},
    {"child", "body2 successor frame_b follower"},
    {"gear_ratio", "gear ratio n"},
    {"step", "dt timestep time_step"},
    {"stop", "end tstop t_end stop_time duration"},
};

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return text::lower(x) == text::lower(y); });
}

}  // namespace

bool contains(Words words, std::string_view word) {
  while (!words.empty()) {
    const std::size_t end = std::min(words.find(' '), words.size());
    if (equal_ignoring_case(words.substr(0, end), word)) return true;
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  return false;
}

std::string canonical_name(std::string_view found, const std::vector<std::string>& known) {
  for (const auto& [ours, theirs] : synonyms) {
    if (contains(theirs, found) && std::ranges::find(known, ours) != known.end()) return std::string(ours);
  }
  return {};
}

}  // namespace gelenk
