// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "joint/registry.h"
#include "scene/check.h"
#include "scene/text.h"
#include "scene/words.h"

namespace gelenk {
namespace {

// The ends of a periodic table: as the file's digits tell them.
constexpr double same_value = 1e-12;

struct Checker {
  const Scene& scene;
  Faults& faults;
  bool partial;
  std::set<std::string> driven{};  // coordinates

  // The joint, if it is there and of one of these kinds.
  const Joint* joint(const std::string& name, const std::string& path, const std::vector<std::string>& kinds) {
    const Joint* found = check_joint_name(scene, name, path, faults, partial);
    if (found == nullptr) return nullptr;
    if (kinds.empty() || std::ranges::find(kinds, found->type) != kinds.end()) return found;
    if (find_joint_kind(found->type) != nullptr) {
      faults.add(path, text::quoted(name) + ", a " + found->type + " joint", "a " + text::list(kinds) + " joint");
    }
    return nullptr;
  }

  // What could not be read is NaN, and has been told. False: so it is.
  bool finite(const double* values, std::size_t n, const std::string& path) {
    if (partial && std::any_of(values, values + n, [](double x) { return std::isnan(x); })) return false;
    check_finite(values, n, path, faults);
    return true;
  }

  void table(const GivenMotion& motion, const std::string& path) {
    const bool times = finite(motion.times.data(), motion.times.size(), path + ".time");
    const bool values = finite(motion.values.data(), motion.values.size(), path + ".value");
    if (!times || !values) return;
    if (motion.times.size() < 2 || motion.times.size() != motion.values.size()) {
      if (partial && (motion.times.empty() || motion.values.empty())) return;
      faults.add(path,
                 std::to_string(motion.times.size()) + " times and " + std::to_string(motion.values.size()) + " values",
                 "as many of both, 2 or more");
      return;
    }
    for (std::size_t i = 1; i < motion.times.size(); ++i) {
      if (motion.times[i] > motion.times[i - 1]) continue;
      faults.add(path + ".time[" + std::to_string(i + 1) + "]", text::number(motion.times[i]) + " s",
                 "more than the time before, " + text::number(motion.times[i - 1]) + " s");
      return;
    }
    const double ends = std::abs(motion.values.back() - motion.values.front());
    double size = 0;
    for (const double x : motion.values) size = std::max(size, std::abs(x));
    if (motion.periodic && !(ends <= same_value * size)) {
      faults.add(path + ".value[" + std::to_string(motion.values.size()) + "]", text::number(motion.values.back()),
                 "the first value, " + text::number(motion.values.front()) + ", as the table is periodic");
    }
  }

  void motion(const Constraint& c, const std::string& path) {
    const Joint* of = joint(c.joint, path + ".joint", {});
    const JointKind* kind = of == nullptr ? nullptr : find_joint_kind(of->type);
    if (kind != nullptr && !kind->springs()) {
      std::vector<std::string> kinds;
      for (const JointKind& k : joint_kinds()) {
        if (k.springs()) kinds.emplace_back(k.name);
      }
      faults.add(path + ".joint", text::quoted(c.joint) + ", a " + of->type + " joint",
                 "a joint of one of the types " + text::list(kinds));
    } else if (kind != nullptr && !(partial && c.coordinate.empty())) {
      if (std::ranges::find(kind->q, c.coordinate, &Quantity::name) == kind->q.end()) {
        faults.add(path + ".coordinate", text::quoted(c.coordinate), "a coordinate of joint " + c.joint);
      } else if (!driven.insert(c.joint + "." + c.coordinate).second) {
        faults.add(path, "a second motion of " + c.joint + "." + c.coordinate, "one motion for each coordinate");
      }
    }
    const GivenMotion& m = c.motion;
    finite(m.polynomial.data(), m.polynomial.size(), path + ".polynomial");
    for (const auto& [value, field] :
         {std::pair(m.amplitude, "sine.amplitude"), std::pair(m.frequency, "sine.frequency"),
          std::pair(m.phase, "sine.phase"), std::pair(m.speed, "speed")}) {
      finite(&value, 1, path + "." + field);
    }
    if (m.frequency < 0) faults.add(path + ".sine.frequency", text::number(m.frequency) + " Hz", "0 Hz or more");
    if (m.source == GivenMotion::Source::table) table(m, path + ".table");
  }

  void gear(const Constraint& c, const std::string& path) {
    const bool rack = c.type == ConstraintType::rack;
    joint(c.joint, path + (rack ? ".rack" : ".joint"), {rack ? "prismatic" : "revolute"});
    joint(c.other, path + (rack ? ".pinion" : ".with"), {"revolute"});
    if (!c.carrier.empty()) joint(c.carrier, path + ".carrier", {"revolute"});
    const bool twice = c.joint == c.other || c.joint == c.carrier || c.other == c.carrier;
    if (twice && !c.joint.empty() && !c.other.empty()) faults.add(path, "a joint twice", "different joints");
    finite(&c.ratio, 1, path + (rack ? ".radius" : ".ratio"));
    finite(&c.offset, 1, path + ".offset");
    if (c.ratio == 0) faults.add(path + (rack ? ".radius" : ".ratio"), "0", "a number other than 0");
  }

  void contact(const Constraint& c, const std::string& path) {
    check_frame(c.at, scene, path, faults, partial);
    check_frame(c.on, scene, path + ".on", faults, partial);
    if (c.at.body == c.on.body && !c.at.body.empty()) {
      faults.add(path, text::quoted(c.at.body) + " as the body and as what it is on", "two different bodies");
    }
    if (!(std::abs(c.axis.norm() - 1) < 1e-9)) {
      faults.add(path + ".axis", "an axis of length " + text::number(c.axis.norm()), "a unit vector");
    }
    if (c.type != ConstraintType::rolling || (partial && std::isnan(c.radius))) return;
    if (!(c.radius > 0) || !std::isfinite(c.radius)) {
      faults.add(path + ".radius", text::number(c.radius) + " m", "more than 0 m");
    }
  }

  // Of what keeps a speed only, dependent coordinates cannot be told.
  void formulation(const Constraint& c, const std::string& path) {
    const bool speeds = c.type == ConstraintType::rolling || c.type == ConstraintType::knife_edge ||
                        (c.type == ConstraintType::motion && c.motion.speed_only());
    if (!speeds || scene.solver.formulation != "independent") return;
    faults.add("solver.formulation", "'independent' with " + path + ", which constrains speeds but no position",
               "another formulation, as projection");
  }

  void run() {
    for (const Constraint& c : scene.constraints) {
      const std::string path = "constraints." + text::printable(c.name);
      switch (c.type) {
        case ConstraintType::motion:
          motion(c, path);
          break;
        case ConstraintType::gear:
        case ConstraintType::rack:
          gear(c, path);
          break;
        case ConstraintType::rolling:
        case ConstraintType::knife_edge:
          contact(c, path);
          break;
      }
      formulation(c, path);
    }
  }
};

}  // namespace

void check_constraints(const Scene& scene, Faults& faults, bool partial) {
  Checker{.scene = scene, .faults = faults, .partial = partial}.run();
}

}  // namespace gelenk
