// SPDX-License-Identifier: BSD-3-Clause
// The shapes of an island that can touch each other, and the laws of its joints that are contacts.
#include <algorithm>

#include "joint/swing_limit.h"
#include "mechanism/graph.h"
#include "mechanism/touching.h"
#include "scene/shapes.h"
#include "scene/touching_laws.h"
#include "util/text.h"

namespace gelenk {
namespace {

int number_of(const std::string& surface, const std::vector<std::string>& surfaces) {
  return static_cast<int>(std::ranges::find(surfaces, surface) - surfaces.begin());
}

ContactTable table_of(const Scene& scene, const BodyNumbers& number) {
  ContactTable out;
  out.surfaces = surfaces_of(scene);
  for (const std::string& a : out.surfaces) {
    for (const std::string& b : out.surfaces) out.contacts.push_back(contact_between(scene, a, b));
  }
  for (const Joint& joint : scene.joints) {
    if (kind_of(*joint.is).nv == 6) continue;  // it constrains nothing
    const int parent = number(joint.parent.body);
    const int child = number(joint.child.body);
    if (parent < 0 || child < 0) continue;  // what is on a joint to the ground may touch the ground, as of a robot
    out.joined.emplace_back(std::min(parent, child), std::max(parent, child));
  }
  std::ranges::sort(out.joined);
  for (const Contact& contact : scene.contacts) {
    out.touches_joined.push_back(includes_joined(*contact.is));
    out.first_surfaces.push_back(number_of(contact.surfaces.front(), out.surfaces));
  }
  return out;
}

bool can_touch(const ContactTable& table, const BodyShape& shape) {
  if (shape.surface.empty()) return false;
  const int surface = number_of(shape.surface, table.surfaces);
  for (int other = 0; other < static_cast<int>(table.surfaces.size()); ++other) {
    if (table.contact(surface, other) >= 0) return true;
  }
  return false;
}

// Whether two shapes of a mechanism can touch by this contact.
bool has_pair(const Mechanism& mechanism, int contact) {
  const ContactTable& table = mechanism.contact_table;
  for (std::size_t a = 0; a < mechanism.shapes.size(); ++a) {
    for (std::size_t b = a + 1; b < mechanism.shapes.size(); ++b) {
      if (contact_between(table, mechanism.shapes[a], mechanism.shapes[b]) == contact) return true;
    }
  }
  return false;
}

// A contact without a pair of shapes would have no gap.
void check_pairs(const Scene& scene, const ReducedScene& reduced) {
  std::vector<std::string> errors;
  for (int c = 0; c < static_cast<int>(scene.contacts.size()); ++c) {
    if (std::ranges::any_of(reduced.islands, [c](const Mechanism& mechanism) { return has_pair(mechanism, c); }))
      continue;
    const Contact& contact = scene.contacts[static_cast<std::size_t>(c)];
    errors.push_back((scene.file.empty() ? "" : scene.file + ": ") + "contacts." + contact.name +
                     ".between: found no shape with the surface " + text::quoted(contact.surfaces[0]) +
                     " that can touch one with " + text::quoted(contact.surfaces[1]) +
                     ", expected two bodies, or a body and the ground, that move relative to each other and, without "
                     "adjacent: true, do not share a joint");
  }
  if (!errors.empty()) throw SceneError(errors);
}

}  // namespace

namespace {

// Of joints that move.
void add_laws_of_joints(const Scene& scene, ReducedScene& reduced) {
  const BodyNumbers number(scene);
  int contact = static_cast<int>(scene.contacts.size());
  for (const TouchingLawOfJoint& of : touching_laws_of_joints(scene)) {
    const int present = contact++;
    const Joint& joint = scene.joints[static_cast<std::size_t>(of.joint)];
    const JointPlace& at = reduced.joints[static_cast<std::size_t>(of.joint)];
    if (at.role != JointPlace::Role::tree && at.role != JointPlace::Role::cut) continue;
    const BodyPlace parent = place(scene, reduced, at.island, joint.parent);
    const BodyPlace child = place(scene, reduced, at.island, joint.child);
    Mechanism& mechanism = reduced.islands[static_cast<std::size_t>(at.island)];
    if (of.friction) {
      const Eigen::Matrix3d R_UC = canonical_rotation(*joint.is, joint.axes);
      mechanism.frictions.push_back({.contact = present,
                                     .link_a = parent.link,
                                     .link_b = child.link,
                                     .turns = of.friction->turns,
                                     .dimension = of.friction->dimension,
                                     .R_a = parent.X_LB.R * R_UC,
                                     .R_b = child.X_LB.R * R_UC,
                                     .body_a = number(joint.parent.body),
                                     .body_b = number(joint.child.body),
                                     .p_b = child.X_LB.p});
    } else {
      mechanism.swings.push_back({.contact = present,
                                  .link_a = parent.link,
                                  .link_b = child.link,
                                  .axis_a = parent.X_LB.R * of.swing->parent_axis.along,
                                  .axis_b = child.X_LB.R * of.swing->child_axis.along,
                                  .angle = of.swing->swing,
                                  .body_a = number(joint.parent.body),
                                  .body_b = number(joint.child.body),
                                  .p_b = child.X_LB.p});
    }
  }
}

}  // namespace

int contact_between(const ContactTable& table, const LinkShape& a, const LinkShape& b) {
  if (a.link == b.link) return -1;
  const int contact = table.contact(a.surface, b.surface);
  if (contact < 0 || table.touches_joined[static_cast<std::size_t>(contact)]) return contact;
  const std::pair pair(std::min(a.scene_body, b.scene_body), std::max(a.scene_body, b.scene_body));
  return std::ranges::binary_search(table.joined, pair) ? -1 : contact;
}

void add_shapes(const Scene& scene, ReducedScene& reduced) {
  add_laws_of_joints(scene, reduced);
  if (scene.contacts.empty()) return;
  const BodyNumbers number(scene);
  const ContactTable table = table_of(scene, number);
  for (std::size_t island = 0; island < reduced.islands.size(); ++island) {
    Mechanism& mechanism = reduced.islands[island];
    const auto add = [&](const BodyShape& shape, const BodyPlace& place, int body) {
      if (!can_touch(table, shape)) return;
      mechanism.shapes.push_back(
          {place.link, place.X_LB * shape.X_BS, shape.is, number_of(shape.surface, table.surfaces), body});
    };
    const Pose3 X_0W = mechanism.X_W0.inverse();
    bool moves = false;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const BodyPlace& place = reduced.bodies[b];
      if (place.island >= 0 && place.island != static_cast<int>(island)) continue;
      const BodyPlace at = place.island < 0 ? BodyPlace{place.island, 0, X_0W * place.X_LB, -1} : place;
      const std::size_t before = mechanism.shapes.size();
      for (const BodyShape& shape : scene.bodies[b].shapes) add(shape, at, static_cast<int>(b));
      moves = moves || (place.island >= 0 && mechanism.shapes.size() > before);
    }
    for (const BodyShape& shape : scene.ground_shapes) add(shape, {-1, 0, X_0W, -1}, -1);
    if (moves) {
      mechanism.contact_table = table;
    } else {
      mechanism.shapes.clear();
    }
  }
  check_pairs(scene, reduced);
}

}  // namespace gelenk
