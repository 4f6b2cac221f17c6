// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <unordered_map>

#include "joint/registry.h"
#include "scene/check.h"
#include "scene/text.h"
#include "scene/units.h"

namespace gelenk {
namespace {

// "crank.com[2]" is base "crank.com" with index "2"; without brackets the index is empty.
struct Split {
  std::string base, index;
};

Split split(const std::string& path) {
  const std::size_t open = path.find('[');
  if (open == std::string::npos || path.back() != ']') return {path, ""};
  return {path.substr(0, open), path.substr(open + 1, path.size() - open - 2)};
}

bool index_fits(const std::string& index, int size) {
  for (int i = 1; i <= size; ++i) {
    if (index == std::to_string(i)) return true;
  }
  return false;
}

// What a path may be whose owner ("crank") is known or not.
std::string expected(const Split& path, const std::vector<Settable>& all) {
  const std::string owner = path.base.substr(0, path.base.find('.'));
  std::vector<std::string> fields;
  std::vector<std::string> owners;
  for (const Settable& s : all) {
    const std::string name = s.path.substr(0, s.path.find('.'));
    if (name == owner) fields.push_back(s.path);
    if (owners.empty() || owners.back() != name) owners.push_back(name);
  }
  if (!fields.empty()) return text::one_of(path.base, fields, "fields");
  const std::string near = text::nearest(owner, owners);
  return "gravity or a field of a body, joint, motor, force or constraint" +
         (near.empty() ? "" : "; did you mean '" + near + "'?");
}

void add_settables(const Constraint& constraint, std::vector<Settable>& out) {
  const std::string& name = constraint.name;
  const GivenMotion& motion = constraint.motion;
  switch (constraint.type) {
    case ConstraintType::motion:
      if (motion.source == GivenMotion::Source::speed) out.push_back({name + ".speed", 1});
      if (!motion.polynomial.empty()) out.push_back({name + ".polynomial", static_cast<int>(motion.polynomial.size())});
      if (has_sine(motion)) {
        out.insert(out.end(),
                   {{name + ".sine.amplitude", 1}, {name + ".sine.frequency", 1}, {name + ".sine.phase", 1}});
      }
      return;
    case ConstraintType::gear:
      out.insert(out.end(), {{name + ".ratio", 1}, {name + ".offset", 1}});
      return;
    case ConstraintType::rack:
      out.insert(out.end(), {{name + ".radius", 1}, {name + ".offset", 1}});
      return;
    case ConstraintType::rolling:
      out.push_back({name + ".radius", 1});
      return;
    case ConstraintType::knife_edge:
      return;
  }
}

}  // namespace

std::vector<Settable> settables(const Scene& scene) {
  std::vector<Settable> out = {{"gravity", 3}};
  for (const Body& body : scene.bodies) {
    out.insert(out.end(), {{body.name + ".mass", 1}, {body.name + ".com", 3}, {body.name + ".inertia", 6}});
  }
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr) continue;
    if (kind->nv > 0) out.push_back({joint.name + ".damping", kind->nv});
    if (kind->springs()) {
      out.insert(out.end(), {{joint.name + ".stiffness", kind->nv}, {joint.name + ".spring_reference", kind->nv}});
    }
    if (joint.stop) {
      const std::string stop = joint.name + ".stop";
      if (std::isfinite(joint.stop->lower)) out.push_back({stop + ".lower", 1});
      if (std::isfinite(joint.stop->upper)) out.push_back({stop + ".upper", 1});
      out.insert(out.end(), {{stop + ".stiffness", 1}, {stop + ".damping", 1}});
    }
    out.insert(out.end(), {{joint.name + ".parent.position", 3}, {joint.name + ".child.position", 3}});
  }
  for (const Motor& motor : scene.motors) {
    out.insert(out.end(), {{motor.name + ".gear_ratio", 1}, {motor.name + ".rotor_inertia", 1}});
  }
  for (const Force& force : scene.forces) {
    if (force.type == ForceType::wrench) {
      out.insert(out.end(), {{force.name + ".force", 3}, {force.name + ".torque", 3}});
    } else {
      out.insert(out.end(),
                 {{force.name + ".stiffness", 1}, {force.name + ".damping", 1}, {force.name + ".length", 1}});
    }
  }
  for (const Constraint& constraint : scene.constraints) add_settables(constraint, out);
  return out;
}

void check_parameters(const Scene& scene, Faults& faults, const Doubtful& doubtful) {
  if (scene.parameters.empty()) return;
  const std::vector<Settable> all = settables(scene);
  std::unordered_map<std::string_view, const Settable*> named;
  for (const Settable& settable : all) named.emplace(settable.path, &settable);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < scene.parameters.size(); ++i) {
    const std::string& parameter = scene.parameters[i];
    const std::string path = "parameters[" + std::to_string(i + 1) + "]";
    const Split given = split(parameter);
    if (parameter.empty() || doubtful.contains(given.base.substr(0, given.base.find('.')))) continue;
    const auto entry = named.find(given.base);
    const Settable* found = entry == named.end() ? nullptr : entry->second;
    if (found == nullptr) {
      faults.add(path, text::quoted(parameter), expected(given, all));
    } else if (!given.index.empty() && found->size == 1) {
      faults.add(path, text::quoted(parameter), found->path + ", which is one number");
    } else if (!given.index.empty() && !index_fits(given.index, found->size)) {
      faults.add(path, text::quoted(parameter), "an index from 1 to " + std::to_string(found->size));
    } else if (!seen.insert(parameter).second || (!given.index.empty() && seen.contains(given.base))) {
      faults.add(path, text::quoted(parameter) + " again", "every parameter once");
    }
  }
}

}  // namespace gelenk
