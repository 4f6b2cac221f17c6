// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/doubts.h"

#include <algorithm>
#include <cmath>

#include "joint/kinds.h"
#include "preparation/report.h"
#include "preparation/start.h"
#include "scene/quantity_groups.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Names the coordinate in which the two assemblies differ most.
std::string describe_equal(const Scene& scene, const ReducedScene& reduced, int island, const Assembled& found,
                           const Dynamics& dynamics) {
  double max_difference = -1;
  std::string name;
  double taken = 0;
  double other = 0;
  for (const int j : reduced.islands[island].joints) {
    if (reduced.joints[j].role != JointPlace::Role::tree) continue;
    const JointKind& kind = *find_joint_kind(scene.joints[j].type);
    const std::vector<double> a = coordinates_of(scene, reduced, j, found.q, dynamics);
    const std::vector<double> b = coordinates_of(scene, reduced, j, found.equal_q, dynamics);
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (std::abs(a[k] - b[k]) <= max_difference) continue;
      max_difference = std::abs(a[k] - b[k]);
      const double size = scene.units.size_of(kind.q[k].unit);
      name = scene.joints[j].name + "." + std::string(kind.q[k].name);
      taken = size * a[k];
      other = size * b[k];
    }
  }
  return describe_equal_assemblies(scene, name, taken, other);
}

bool is_set(const JointStart& start, std::size_t k) { return k < start.q_set.size() && start.q_set[k]; }

// Whether parameters set start positions of an island: the guesses of the file are then those for another start, and
// are expected to follow.
bool is_any_set(const Scene& scene, const Mechanism& island) {
  return std::ranges::any_of(island.joints, [&](int j) {
    const std::vector<bool>& set = scene.joints[j].start.q_set;
    return std::ranges::find(set, true) != set.end();
  });
}

// The guess of a position, as the message on its change names it: set by a parameter, or in the file.
std::string name_of_guess(const std::string& joint, std::string_view coordinate, bool is_set) {
  return is_set ? start_parameter(joint, coordinate) : "joints." + joint + ".start." + std::string(coordinate);
}

std::string guess_advice(const std::string& joint, bool is_set) {
  return is_set ? joint + ".fixed keeps it exactly" : "gelenk assemblies lists all positions";
}

// Describes a guess of another position than that in which the mechanism starts. Positions of free bodies, which are
// sketched roughly, do not count.
std::string describe_changed_guess(const Scene& scene, const ReducedScene& reduced, int island, const Assembled& found,
                                   const Dynamics& dynamics) {
  double max_change = 0.1;  // rad, natural units of length: beyond, assembly looks for other positions
  if (found.moved <= max_change) return {};
  const bool only_set = is_any_set(scene, reduced.islands[island]);
  std::string out;
  for (const int j : reduced.islands[island].joints) {
    const Joint& joint = scene.joints[j];
    const JointStart& guess = joint.start;
    const JointKind& kind = *find_joint_kind(joint.type);
    const JointPlace::Role role = reduced.joints[j].role;
    if ((role != JointPlace::Role::tree && role != JointPlace::Role::cut) || kind.has_quaternion()) continue;
    const std::vector<double> q = coordinates_of(scene, reduced, j, found.q, dynamics);
    for (std::size_t k = 0; k < q.size(); ++k) {
      if (!guess.q_given[k] || guess.q_fixed[k] || (only_set && !is_set(guess, k))) continue;
      // Free angles are within half a turn of their guesses; full turns of the others count.
      const double change = std::abs(q[k] - guess.q[k]);
      if (change <= max_change) continue;
      max_change = change;
      const auto shown = [&](double x) {
        return text::with_unit(text::rounded(scene.units.size_of(kind.q[k].unit) * x), kind.q[k].unit);
      };
      out = name_of_guess(joint.name, kind.q[k].name, only_set) + ": found " + shown(guess.q[k]) +
            ", a guess with which the loops cannot be closed, expected one near " + shown(q[k]) + ", which is used; " +
            guess_advice(joint.name, only_set);
    }
  }
  return out.empty() || scene.file.empty() || only_set ? out : scene.file + ": " + out;
}

}  // namespace

void add_doubts(const Scene& scene, const ReducedScene& reduced, int island, const Assembled& found,
                const Dynamics& dynamics, std::vector<std::string>& warnings) {
  if (!found.equal_q.empty()) warnings.push_back(describe_equal(scene, reduced, island, found, dynamics));
  const std::string changed = describe_changed_guess(scene, reduced, island, found, dynamics);
  if (!changed.empty()) warnings.push_back(changed);
}

std::string describe_odd_axis(const Scene& scene, const std::vector<int>& joints) {
  constexpr double sine_limit = 1e-6;
  if (joints.size() < 4) return {};
  std::vector<Eigen::Vector3d> axes;
  for (const int j : joints) {
    const Joint& joint = scene.joints[j];
    if (joint.axes.size() != 1) return {};
    axes.emplace_back(joint.parent.X_BF.R * joint.axes.front());
  }
  const auto parallel = [&](std::size_t i, std::size_t k) { return axes[i].cross(axes[k]).norm() < sine_limit; };
  const Joint* odd = nullptr;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    std::size_t others = 0;
    for (std::size_t k = 0; k < axes.size(); ++k) others += k != i && parallel(i, k) ? 1 : 0;
    if (others + 2 >= axes.size()) continue;  // parallel to all, or to all but the odd one
    if (others > 0 || odd != nullptr) return {};
    odd = &scene.joints[joints[i]];
  }
  if (odd == nullptr) return {};
  return "Check the axis of joint " + odd->name + ": those of all other joints in the loop are parallel.";
}

}  // namespace gelenk
