// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "check/check.h"
#include "check/fields.h"
#include "joint/isotropic_friction.h"
#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Checks sizes and values, which are correct after reading a file but may be wrong if a program set them.
void check_numbers(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  const auto nq = static_cast<std::size_t>(kind.nq);
  const auto nv = static_cast<std::size_t>(kind.nv);
  const auto sized = [&](const auto& list, std::size_t size, const char* field) {
    if (list.size() == size) return true;
    faults.add(path + "." + field, "a list of " + std::to_string(list.size()), "a list of " + std::to_string(size));
    return false;
  };
  const JointStart& s = joint.start;
  sized(s.q_given, nq, "start.q_given");
  sized(s.q_fixed, nq, "start.q_fixed");
  sized(s.v_given, nv, "start.v_given");
  sized(s.v_fixed, nv, "start.v_fixed");
  if (sized(s.q, nq, "start.q")) check_finite(s.q.data(), nq, path + ".start.q", faults);
  if (sized(s.v, nv, "start.v")) check_finite(s.v.data(), nv, path + ".start.v", faults);
  sized(joint.along, nv, "along");
  for (const auto* list : {&s.q_weight, &s.v_weight}) {
    if (sized(*list, list == &s.q_weight ? nq : nv, "start.weight")) {
      check_finite(list->data(), list->size(), path + ".start.weight", faults);
    }
  }
  const auto negative = [](double x) { return x < 0; };
  for (const auto* list : {&s.q_weight, &s.v_weight}) {
    const auto bad = std::ranges::find_if(*list, negative);
    if (bad != list->end()) faults.add(path + ".start.weight", text::number(*bad), "0 or more");
  }
}

void check_axes(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  if (joint.axes.size() != static_cast<std::size_t>(kind.axes)) {
    return faults.add(path + ".axes", std::to_string(joint.axes.size()) + " axes", std::to_string(kind.axes));
  }
  for (const Eigen::Vector3d& axis : joint.axes) {
    if (!(std::abs(axis.norm() - 1) < 1e-9)) {
      faults.add(path + ".axes", "an axis of length " + text::number(axis.norm()), "unit vectors");
    }
  }
}

// Sets of connected bodies (union-find): a forest in which each root represents a set.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::size_t> parent_;
};

// Friction of both translations together leaves none of one of them.
void check_friction_parts(const Joint& joint, const std::string& path, const JointForceKind& kind, Faults& faults) {
  const JointKind& of = kind_of(*joint.is);
  for (const FrictionPart& part : friction_parts_of(*joint.is)) {
    for (std::size_t i = 0; i < joint.along.size() && kind.group == "friction"; ++i) {
      const int number = static_cast<int>(i);
      if (kind.in(*joint.along[i]) == nullptr || coordinate_of(of, number).is_angle != part.turns) continue;
      faults.add(path + "." + group_along(kind.group, of, number),
                 "friction along this coordinate beside " + std::string(part.key), "one of them");
    }
  }
}

// path: of the joint.
void check_forces(const Joint& joint, const std::string& path, const JointForceKind& kind, Faults& faults) {
  for (std::size_t i = 0; i < joint.along.size(); ++i) {
    const std::string group = group_along(kind.group, kind_of(*joint.is), static_cast<int>(i));
    check_force(joint, i, group.empty() ? path : path + "." + group, kind, faults);
  }
}

}  // namespace

void check_force(const Joint& joint, std::size_t i, const std::string& path, const JointForceKind& kind,
                 Faults& faults) {
  const void* there = kind.in(*joint.along[i]);
  if (there == nullptr) return;
  const Coordinate coordinate = coordinate_of(kind_of(*joint.is), static_cast<int>(i));
  check_element(kind.fields, there, path, coordinate, [&] { return kind.fault(there, coordinate); }, faults);
}

void check_joints(const Scene& scene, Faults& faults, bool partial) {
  for (const Joint& joint : scene.joints) {
    const std::string path = "joints." + text::printable(joint.name);
    check_frame(joint.parent, scene, path + ".parent", faults, partial);
    check_frame(joint.child, scene, path + ".child", faults, partial);
    if (joint.parent.body == joint.child.body && !joint.parent.body.empty()) {
      faults.add(path, text::quoted(joint.parent.body) + " as parent and as child", "two different bodies");
    }
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind != nullptr) {
      check_axes(joint, *kind, path, faults);
      check_numbers(joint, *kind, path, faults);
      check_element(kind->fields, data_of(*joint.is), path, {}, [&] { return fault_of(*joint.is); }, faults);
      for (const JointForceKind& force : joint_force_kinds()) {
        if (!partial && force.fits(*kind)) {
          check_forces(joint, path, force, faults);
          check_friction_parts(joint, path, force, faults);
        }
      }
    } else if (!partial || !joint.type.empty()) {
      faults.add(path + ".type", text::quoted(joint.type), "the name of a kind of joint");
    }
  }
}

void check_connection(const Scene& scene, Faults& faults) {
  if (scene.joints.empty()) return;  // reported already
  std::map<std::string, std::size_t> index = {{ground, 0}};
  for (const Body& body : scene.bodies) index.try_emplace(body.name, index.size());
  DisjointSets sets(index.size());
  for (const Joint& joint : scene.joints) {
    const auto parent = index.find(joint.parent.body);
    const auto child = index.find(joint.child.body);
    if (parent == index.end() || child == index.end()) return;  // reported already; its connections are unknown
    sets.join(parent->second, child->second);
  }
  std::vector<std::string> disconnected;
  for (const Body& body : scene.bodies) {
    if (sets.root(index[body.name]) != sets.root(0)) disconnected.push_back(body.name);
  }
  if (disconnected.empty()) return;
  faults.add("bodies", "no chain of joints from ground to " + text::list(disconnected),
             "every body connected to ground (a floating body has a joint of type free)");
}

}  // namespace gelenk
