// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "check/check.h"
#include "check/fields.h"
#include "element/locking.h"
#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "scene/formulas.h"
#include "scene/motions.h"
#include "scene/shapes.h"
#include "scene/touching_laws.h"
#include "shape/features.h"
#include "shape/rounded.h"
#include "util/text.h"

namespace gelenk {
namespace {

const Joint* find_joint(const Scene& scene, const std::string& name, const std::string& path, Faults& faults) {
  const auto found = std::ranges::find(scene.joints, name, &Joint::name);
  if (found != scene.joints.end()) return &*found;
  std::vector<std::string> names;
  for (const Joint& joint : scene.joints) names.push_back(joint.name);
  faults.add(path, text::quoted(name), text::one_of(name, names, "joints"));
  return nullptr;
}

// Describes the kinds of joints that a port accepts.
std::string fitting_joints(const Port& port) {
  std::vector<std::string> kinds;
  for (const JointKind& kind : joint_kinds()) {
    if (port.fits(kind)) kinds.emplace_back(kind.name);
  }
  return kinds.size() == 1 ? "a " + kinds[0] + " joint" : "a joint of one of the types " + text::list(kinds);
}

// Checks the elements of one section.
struct Checker {
  const Scene& scene;
  const Section& section;
  Faults& faults;
  bool partial;
  std::set<std::string> prescribed{};          // coordinates that have a prescribed motion
  std::set<std::vector<std::string>> pairs{};  // of surfaces that have a contact

  void joint(const Port& port, const std::string& name, const std::string& path) {
    if (name.empty() && (partial || port.optional)) return;
    const Joint* found = find_joint(scene, name, path, faults);
    const JointKind* kind = found == nullptr ? nullptr : find_joint_kind(found->type);
    if (kind == nullptr || port.fits == nullptr || port.fits(*kind)) return;
    faults.add(path, text::quoted(name) + ", a " + found->type + " joint", fitting_joints(port));
  }

  // Whether a joint rotates or translates as the first one of the element does; both have one coordinate.
  void alike(const ElementPlace& element, const std::string& name, const std::string& path) {
    const JointKind* first = kind_of_joint(scene, element.joints.front());
    const JointKind* second = kind_of_joint(scene, name);
    if (first == nullptr || second == nullptr || first->nq != 1 || second->nq != 1) return;
    if (first->q[0].unit == second->q[0].unit) return;
    faults.add(path, text::quoted(name) + ", a " + std::string(second->name) + " joint",
               "a joint that moves as " + element.joints.front() + ", a " + std::string(first->name) +
                   " joint, does; a rack couples a rotation and a translation");
  }

  void coordinate(const ElementPlace& element, const Port& port, const std::string& path) {
    const JointKind* kind = kind_of_joint(scene, element.joints.front());
    if (kind == nullptr || (partial && element.coordinate.empty())) return;
    if (port.fits != nullptr && !port.fits(*kind)) return;                           // reported already
    if (!port.is_prescribed && element.coordinate.empty() && kind->nq == 1) return;  // the only one
    const std::string whole = element.joints.front() + "." + element.coordinate;
    if (std::ranges::find(kind->q, element.coordinate, &Quantity::name) == kind->q.end()) {
      faults.add(path + ".coordinate", text::quoted(element.coordinate),
                 "a coordinate of joint " + element.joints.front());
    } else if (port.is_prescribed && !prescribed.insert(whole).second) {
      faults.add(path, "a second motion of " + whole, "one motion per coordinate");
    }
  }

  void frame(const Port& port, const BodyFrame& frame, const std::string& path) {
    const std::string own = port.name.empty() ? path : path + "." + std::string(port.name);
    check_frame(frame, scene, own, faults, partial);
    if (!port.on_ground && frame.body == ground) faults.add(own + ".body", "'ground'", "a body that a force can move");
  }

  void surfaces(const ElementPlace& element, const std::string& path) {
    if (partial) return;
    const std::vector<std::string> known = surfaces_of(scene);
    for (const std::string& name : element.surfaces) {
      if (name.empty() || std::ranges::find(known, name) != known.end()) continue;
      faults.add(path, text::quoted(name), text::one_of(name, known, "surfaces of shapes"));
    }
    std::vector<std::string> pair = element.surfaces;
    std::ranges::sort(pair);
    if (!pairs.insert(pair).second) {
      faults.add(path, "a second contact between " + pair[0] + " and " + pair[1], "one contact for each pair");
    }
  }

  void ports(const ElementPlace& element, const ElementKind& kind, const std::string& path) {
    std::size_t frames = 0;
    std::size_t joints = 0;
    for (const Port& port : kind.ports) {
      if (port.kind == Port::Kind::surfaces) {
        surfaces(element, path + "." + std::string(port.name));
        continue;
      }
      if (port.is_frame()) {
        frame(port, element.frames.at(frames++), path);
        continue;
      }
      joint(port, element.joints.at(joints++), path + "." + std::string(port.name));
      if (port.is_alike) alike(element, element.joints.at(joints - 1), path + "." + std::string(port.name));
      if (port.has_coordinate) coordinate(element, port, path);
    }
    if (section.name == sensors_section.name) return;
    const auto duplicate = [](std::vector<std::string> names) {
      std::erase(names, "");
      std::ranges::sort(names);
      const auto found = std::ranges::adjacent_find(names);
      return found == names.end() ? std::string() : *found;
    };
    std::vector<std::string> bodies;
    for (const BodyFrame& frame : element.frames) bodies.push_back(frame.body);
    if (const std::string body = duplicate(bodies); !body.empty()) {
      faults.add(path, text::quoted(body) + " twice", "two different bodies");
    }
    if (!duplicate(element.joints).empty()) faults.add(path, "a joint twice", "different joints");
  }

  template <class Any>
  void run(const std::vector<Element<Any>>& elements) {
    for (const Element<Any>& element : elements) {
      if (!element.component.empty()) continue;  // checked with its component
      const std::string path = std::string(section.name) + "." + text::printable(element.name);
      ports(element, kind_of(*element.is), path);
      if (kind_of(*element.is).reads_gravity && scene.gravity_field)
        faults.add(path, "a sensor of gravity in a scene with a gravity field", "uniform gravity, or another sensor");
      if (!partial) check_numbers(element, path, coordinate_of(scene, element), faults);
    }
  }
};

// Two shapes that can touch by a contact, but not by tips, edges and rims (shape/features.h); empty: there are none.
std::string pair_without_tips(const Scene& scene, const Contact& contact) {
  std::string out;
  each_pair_of_shapes(scene, contact, [&](const BodyShape& a, const BodyShape& b) {
    if (!out.empty() || located_features(*a.is, *b.is) > 0) return;
    const std::string first(kind_of(*a.is).kind);
    const std::string second(kind_of(*b.is).kind);
    out = first == second ? "two shapes of kind " + first : "a " + first + " and a " + second;
  });
  return out;
}

// Whether the integrator steps with impulses.
bool steps_with_impulses(const Scene& scene) {
  const std::string& integrator = scene.solver.integrator;
  return integrator == "moreau-jean" || (has_touching_laws(scene) && (integrator.empty() || integrator == "auto"));
}

// Contacts that change at events.
void check_located_contacts(const Scene& scene, Faults& faults) {
  const Solver& solver = scene.solver;
  const std::string with = text::quoted(solver.integrator) + " with contacts.";
  if (solver.formulation != "projection" && !solver.formulation.empty())
    faults.add("solver.formulation",
               text::quoted(solver.formulation) + " with " + text::printable(path_of_touching_law(scene, 0)),
               "the formulation projection");
  for (const Contact& contact : scene.contacts) {
    const std::string pair = pair_without_tips(scene, contact);
    if (pair.empty()) continue;
    faults.add("solver.integrator", with + text::printable(contact.name) + ", which is between " + pair,
               "auto or moreau-jean: contacts are located between a plane and spheres, capsules, boxes, hulls, "
               "cylinders and wheels, and between spheres, capsules and boxes");
  }
}

void check_contact_methods(const Scene& scene, Faults& faults) {
  const Solver& solver = scene.solver;
  if (!steps_with_impulses(scene) && has_touching_laws(scene)) {
    check_located_contacts(scene, faults);
  } else if (steps_with_impulses(scene) && solver.formulation != "projection" && !solver.formulation.empty()) {
    const std::string with = solver.integrator == "moreau-jean" ? "the integrator moreau-jean"
                                                                : text::printable(path_of_touching_law(scene, 0));
    faults.add("solver.formulation", text::quoted(solver.formulation) + " with " + with, "the formulation projection");
  }
}

// What steps with impulses cannot do: resets of states are located events, which these do not have, and of forces they
// know means over a step.
void check_what_needs_events(const Scene& scene, Faults& faults) {
  const auto refuse = [&](const std::string& path, const std::string& what) {
    if (!steps_with_impulses(scene)) return;
    std::string found = what;
    if (scene.solver.integrator == "moreau-jean") {
      found += " with the integrator moreau-jean";
    } else if (const std::string reason = reason_for_time_steps(scene); !reason.empty()) {
      found += " with contacts that are solved in time steps: " + reason;
    } else {
      return;
    }
    faults.add(path, found, "an integrator and contacts that locate events");
  };
  for (const ElementState& state : scene.states) {
    const std::string path = "states." + text::printable(state.name);
    if (!state.resets.empty()) refuse(path + ".resets", "resets");
    if (state.rate.reads_forces()) refuse(path, "a rate that names forces");
  }
  for (const Constraint& of : scene.constraints) {
    if (find_motion_of_signals(of) != nullptr)
      refuse("constraints." + text::printable(of.name), "a motion that follows states");
  }
}

void check_equilibria_of_states(const Scene& scene, Faults& faults) {
  if (scene.solver.start != "equilibrium") return;
  const auto refuse = [&](const std::string& what, const std::string& expected) {
    faults.add("solver.start", "'equilibrium' with states." + what, "as_given: " + expected);
  };
  if (const ElementState* const state = first_with_resets(scene))
    refuse(text::printable(state->name) + ".resets", "where states jump, there may be no equilibrium");
  if (const ElementState* const state = first_with_rate_of_forces(scene))
    refuse(text::printable(state->name), "no equilibrium is searched for where rates name forces");
}

// Dependent coordinates cannot be solved for if a constraint acts on velocities only; and only `projection` keeps
// coordinates at rest.
void check_formulation(const Scene& scene, Faults& faults) {
  if (scene.solver.formulation != "projection" && !scene.solver.formulation.empty()) {
    for (const Joint& joint : scene.joints) {
      if (joint.locking_element().empty()) continue;
      faults.add("solver.formulation",
                 text::quoted(scene.solver.formulation) + " with joints." + text::printable(joint.name) + "." +
                     std::string(joint.locking_element()),
                 "the formulation projection");
      break;
    }
  }
  if (scene.solver.formulation != "independent") return;
  for (const Constraint& c : scene.constraints) {
    if (holds_positions(*c.is)) continue;
    faults.add(
        "solver.formulation",
        "'independent' with constraints." + text::printable(c.name) + ", which constrains velocities but no positions",
        "another formulation, such as projection");
  }
}

}  // namespace

template <class Any>
void check_numbers(const Element<Any>& element, const std::string& path, const Coordinate& coordinate, Faults& faults) {
  check_element(
      kind_of(*element.is).fields, data_of(*element.is), path, coordinate,
      [&] { return fault_of(*element.is, coordinate); }, faults);
}
template void check_numbers(const Motor&, const std::string&, const Coordinate&, Faults&);
template void check_numbers(const Force&, const std::string&, const Coordinate&, Faults&);
template void check_numbers(const Constraint&, const std::string&, const Coordinate&, Faults&);
template void check_numbers(const Contact&, const std::string&, const Coordinate&, Faults&);
template void check_numbers(const Sensor&, const std::string&, const Coordinate&, Faults&);
template void check_numbers(const Component&, const std::string&, const Coordinate&, Faults&);

void check_elements(const Scene& scene, Faults& faults, bool partial) {
  each_section(scene, [&](const Section& section, const auto& elements) {
    Checker{.scene = scene, .section = section, .faults = faults, .partial = partial}.run(elements);
  });
  check_formulation(scene, faults);
  check_contact_methods(scene, faults);
  check_what_needs_events(scene, faults);
  check_equilibria_of_states(scene, faults);
}

}  // namespace gelenk
