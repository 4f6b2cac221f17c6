// SPDX-License-Identifier: BSD-3-Clause
#include "scene/signals.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string_view>

#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "scene/scene.h"
#include "scene/touching_laws.h"

namespace gelenk {
namespace {

const JointKind& kind_named(const std::string& type) {
  const JointKind* kind = find_joint_kind(type);
  if (kind == nullptr) throw std::out_of_range("no kind of joint is called " + type);
  return *kind;
}

// Appends the signals of one group of an element; `of` has what they have in common.
void add_group(std::vector<Signal>& signals, const SignalGroup& group, const ElementPlace& element,
               const Coordinate& coordinate, Signal of) {
  static constexpr std::string_view components[] = {"x component", "y component", "z component", "scalar part"};
  const std::string name = element.name + "." + filled_in(group.name, element, coordinate);
  of.description = element.name + ": " + filled_in(group.text, element, coordinate);
  of.unit = unit_of(group.unit, coordinate);
  of.stage = group.stage;
  for (int i = 0; i < group.count(); ++i) {
    of.component = i;
    Signal& signal = signals.emplace_back(of);
    signal.name = name;
    if (group.size == 0) continue;
    signal.name += "[" + std::to_string(i + 1) + "]";
    signal.description += ", " + std::string(components[i]);
  }
}

void add_level(std::vector<Signal>& signals, const Joint& joint, int index, int level,
               std::span<const Quantity> quantities) {
  const JointKind& kind = kind_of(*joint.is);
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const Quantity& q = quantities[i];
    const auto component = static_cast<int>(i);
    const bool has_rate = level == 1 || (level == 0 && !kind.is_of_quaternion(component));
    const auto rate = static_cast<int>(signals.size() + quantities.size());
    signals.push_back({.name = joint.name + "." + std::string(q.name),
                       .unit = std::string(q.unit),
                       .description = joint.name + ": " + std::string(q.description),
                       .stage = static_cast<Stage>(level),
                       .joint = index,
                       .level = level,
                       .component = component,
                       .derivative = has_rate ? rate : -1});
  }
}

// "A.lock.s_x.f", or "A.lock.tau[1]" along the angular velocity w[1]: the force of an element that acts on the whole
// joint along one of several velocities.
std::string force_name(const Joint& joint, std::string_view group, const std::string& name, const Coordinate& at) {
  const std::string path = joint.name + "." + std::string(group) + ".";
  if (kind_of(*joint.is).nv == 1) return path + name;
  if (!at.name.empty()) return path + std::string(at.name) + "." + name;
  return path + name + std::string(at.speed.substr(std::min(at.speed.find('['), at.speed.size())));
}

// Appends the signals of an element that acts on the whole joint: a force along each velocity, and what it has once.
void add_of_joint(std::vector<Signal>& signals, const Joint& joint, std::string_view group,
                  std::span<const SignalGroup> all, const Signal& of) {
  const ElementPlace place{.name = joint.name, .frames = {}, .joints = {joint.name}, .coordinate = {}};
  const JointKind& kind = kind_of(*joint.is);
  for (std::size_t g = 0; g < all.size(); ++g) {
    const bool is_force = all[g].name == "{effort}";
    for (int i = 0; i < (is_force ? kind.nv : 1); ++i) {
      const Coordinate at = coordinate_of(kind, i);
      const std::string name = filled_in(all[g].name, place, at);
      Signal& signal = signals.emplace_back(of);
      signal.name = is_force ? force_name(joint, group, name, at) : joint.name + "." + std::string(group) + "." + name;
      signal.unit = unit_of(all[g].unit, at);
      signal.description = joint.name + ": " + filled_in(all[g].text, place, at);
      signal.stage = all[g].stage;
      signal.component = i;
      signal.group = static_cast<int>(g);
      if (all[g].start == SignalGroup::Start::one) signal.start = 1;
    }
  }
}

// Appends the signals of the elements along the velocities of a joint; groups(kind, element) returns their groups.
template <class Groups>
void add_along(std::vector<Signal>& signals, const Joint& joint, int index, Groups groups) {
  const ElementPlace place{.name = joint.name, .frames = {}, .joints = {joint.name}, .coordinate = {}};
  for (std::size_t i = 0; i < joint.along.size(); ++i) {
    const Coordinate coordinate = coordinate_of(kind_of(*joint.is), static_cast<int>(i));
    for (std::size_t k = 0; k < joint_force_kinds().size(); ++k) {
      const JointForceKind& kind = joint_force_kinds()[k];
      const void* element = kind.in(*joint.along[i]);
      if (element == nullptr) continue;
      const std::span<const SignalGroup> all = groups(kind, element);
      if (kind.of_joint) {
        Signal of;
        of.joint = index;
        of.level = 3;
        of.element = static_cast<int>(k);
        add_of_joint(signals, joint, kind.group, all, of);
        continue;
      }
      for (std::size_t g = 0; g < all.size(); ++g) {
        const SignalGroup& group = all[g];
        signals.push_back({.name = joint.name + "." + group_along(kind.group, kind_of(*joint.is), static_cast<int>(i)) +
                                   "." + filled_in(group.name, place, coordinate),
                           .unit = unit_of(group.unit, coordinate),
                           .description = joint.name + ": " + filled_in(group.text, place, coordinate),
                           .stage = group.stage,
                           .joint = index,
                           .level = 3,
                           .component = static_cast<int>(i),
                           .element = static_cast<int>(k),
                           .group = static_cast<int>(g)});
      }
    }
  }
}

int inputs_along_count(const JointForces& forces) {
  int out = 0;
  for (const JointForceKind& kind : joint_force_kinds()) {
    if (const void* element = kind.in(forces)) out += count_of(kind.inputs(element));
  }
  return out;
}

std::span<const SignalGroup> inputs_along(const JointForceKind& kind, const void* element) {
  return kind.inputs(element);
}

double start_of(SignalGroup::Start start, const Scene& scene, const ElementPlace& element) {
  if (start == SignalGroup::Start::zero) return 0;
  if (start == SignalGroup::Start::one) return 1;
  const Joint& joint = *std::ranges::find(scene.joints, element.joints.front(), &Joint::name);
  const auto i = static_cast<std::size_t>(component_of(kind_of(*joint.is), element.coordinate));
  return start == SignalGroup::Start::speed ? joint.start.v[i] : joint.start.q[i];
}

// Appends the signals of all elements of a section; groups(element) returns their groups.
template <class Any, class Groups>
void add_section(std::vector<Signal>& signals, const Scene& scene, int section,
                 const std::vector<Element<Any>>& elements, Groups groups) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::span<const SignalGroup> all = groups(elements[i]);
    if (all.empty()) continue;
    const Coordinate coordinate = coordinate_of(scene, elements[i]);
    for (std::size_t g = 0; g < all.size(); ++g) {
      Signal of;
      of.section = section;
      of.element = static_cast<int>(i);
      of.group = static_cast<int>(g);
      of.start = start_of(all[g].start, scene, elements[i]);
      add_group(signals, all[g], elements[i], coordinate, of);
    }
  }
}

// After those of the contacts, as they are numbered.
void add_touching_laws_of_joints(std::vector<Signal>& signals, const Scene& scene) {
  int i = static_cast<int>(scene.contacts.size()) - 1;
  for (const TouchingLawOfJoint& law : touching_laws_of_joints(scene)) {
    ++i;
    const ElementPlace place{.name = name_of_touching_law(scene, i), .frames = {}, .joints = {}, .coordinate = {}};
    const std::span<const SignalGroup> groups = outputs_of(law);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      Signal of;
      of.section = sections::contacts;
      of.element = i;
      of.group = static_cast<int>(g);
      add_group(signals, groups[g], place, {}, of);
    }
  }
}

// Adds the signal of something that the scene names itself; kind: its description if it has no text.
template <class Named>
Signal& add_named(std::vector<Signal>& signals, const Named& named, std::string_view kind) {
  Signal& signal = signals.emplace_back();
  signal.name = named.name;
  signal.unit = named.unit.empty() ? "1" : named.unit;
  signal.description = named.text.empty() ? kind : named.text;
  return signal;
}

}  // namespace

std::vector<Signal> input_signals(const Scene& scene) {
  std::vector<Signal> signals;
  int section = 0;
  each_section(scene, [&](const Section&, const auto& elements) {
    add_section(signals, scene, section++, elements, [](const auto& element) { return inputs_of(*element.is); });
  });
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    add_along(signals, scene.joints[j], static_cast<int>(j), inputs_along);
  for (const SceneInput& input : scene.inputs) {
    add_named(signals, input, "input of expressions").start = input.start;
  }
  return signals;
}

std::vector<std::vector<int>> first_inputs(const Scene& scene) {
  std::vector<std::vector<int>> out;
  int input = 0;
  each_section(scene, [&](const Section&, const auto& elements) {
    std::vector<int>& of = out.emplace_back();
    for (const auto& element : elements) {
      of.push_back(input);
      input += input_count(*element.is);
    }
  });
  out.emplace_back();
  for (const Joint& joint : scene.joints) {
    out[sections::joints].push_back(input);
    for (const Stored<JointForces>& forces : joint.along) input += inputs_along_count(*forces);
  }
  out.push_back({input});
  return out;
}

std::vector<Signal> output_signals(const Scene& scene) {
  std::vector<Signal> signals;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const JointKind& kind = kind_named(joint.type);
    add_level(signals, joint, static_cast<int>(j), 0, kind.q);
    add_level(signals, joint, static_cast<int>(j), 1, kind.v);
    add_level(signals, joint, static_cast<int>(j), 2, kind.a);
    add_along(signals, joint, static_cast<int>(j),
              [](const JointForceKind& kind, const void*) { return kind.outputs; });
  }
  const auto groups = [](const auto& element) { return kind_of(*element.is).outputs; };
  add_section(signals, scene, sections::sensors, scene.sensors, groups);
  add_section(signals, scene, sections::motors, scene.motors, groups);
  add_section(signals, scene, sections::forces, scene.forces, groups);
  add_section(signals, scene, sections::constraints, scene.constraints, groups);
  add_section(signals, scene, sections::contacts, scene.contacts, groups);
  add_touching_laws_of_joints(signals, scene);
  for (std::size_t i = 0; i < scene.states.size(); ++i) {
    const ElementState& state = scene.states[i];
    Signal& signal = add_named(signals, state, "state of expressions");
    signal.section = sections::states;
    signal.element = static_cast<int>(i);
    signal.group = 0;
    signal.derivative = static_cast<int>(signals.size());
    Signal rate = signal;
    rate.name += ".rate";
    rate.unit = state.unit.empty() ? "1/s" : state.unit + "/s";
    rate.description = "rate of " + state.name;
    rate.stage = state.rate.reads_forces() ? Stage::acceleration : Stage::velocity;
    rate.group = 1;
    rate.derivative = -1;
    signals.push_back(rate);
  }
  for (std::size_t i = 0; i < scene.expressions.size(); ++i) {
    Signal& signal = add_named(signals, scene.expressions[i], "expression");
    signal.stage = scene.expressions[i].value.reads_forces() ? Stage::acceleration : Stage::velocity;
    signal.section = sections::expressions;
    signal.element = static_cast<int>(i);
  }
  return signals;
}

std::vector<Signal> diagnostic_signals() {
  std::vector<Signal> signals(diagnostic_count);
  const auto set = [&signals](Diagnostic which, const char* name, const char* unit, const char* description) {
    Signal& s = signals[static_cast<std::size_t>(which)];
    s.name = name;
    s.unit = unit;
    s.description = description;
  };
  set(Diagnostic::constraint_position, "constraints.position", "1",
      "largest position error of the constraint equations, such as the closure error of a loop: m for distances, rad "
      "for angles");
  set(Diagnostic::constraint_velocity, "constraints.velocity", "1",
      "largest velocity error of the constraint equations: m/s for distances, rad/s for angles");
  set(Diagnostic::kinetic_energy, "energy.kinetic", "J", "kinetic energy of the mechanism");
  set(Diagnostic::potential_energy, "energy.potential", "J", "potential energy of gravity, springs and stops");
  set(Diagnostic::total_energy, "energy.total", "J", "total energy: kinetic plus potential energy");
  set(Diagnostic::steps, "solver.steps", "1", "integrator steps since initialization");
  set(Diagnostic::evaluations, "solver.evaluations", "1",
      "evaluations of the equations of motion since initialization");
  set(Diagnostic::rejected_steps, "solver.rejected_steps", "1", "rejected integrator steps since initialization");
  set(Diagnostic::jacobians, "solver.jacobians", "1", "Jacobian evaluations of implicit methods since initialization");
  set(Diagnostic::singular_positions, "solver.singular_positions", "1",
      "singular configurations crossed since initialization, at which branches of motion meet");
  set(Diagnostic::events, "solver.events", "1",
      "events since initialization: stops, friction and limits that engage or disengage, singular configurations "
      "crossed");
  set(Diagnostic::impacts, "solver.impacts", "1", "impacts on limits since initialization");
  set(Diagnostic::zeno, "solver.zeno", "1", "infinite series of impacts since initialization, ended in contact");
  set(Diagnostic::ambiguous, "solver.ambiguous", "1",
      "events since initialization with an uncertain outcome: friction and limits permit more than one motion or none "
      "exactly, or the order of impacts is within the tolerance");
  set(Diagnostic::cone_residual, "solver.cone_residual", "m/s",
      "largest velocity by which the impulses of contacts, friction and limits of the last communication step fail "
      "their laws");
  set(Diagnostic::cone_iterations, "solver.cone_iterations", "1",
      "most iterations for the impulses of contacts, friction and limits in the last communication step, for one of "
      "its problems");
  set(Diagnostic::contact_points, "solver.contact_points", "1",
      "contact points that have transmitted a force in the last step");
  set(Diagnostic::scheme, "solver.scheme", "1",
      "how contacts are solved at present: 0 at located events, 1 by impulses in steps");
  set(Diagnostic::step_error, "solver.step_error", "1",
      "estimated error of positions by time steps with impulses of the integrator auto, the largest since "
      "initialization: m for distances, rad for angles");
  set(Diagnostic::law_excess, "solver.law_excess", "1",
      "by how much forces of friction, limits and contacts exceed their laws at present, relative to what rounding and "
      "tolerances explain; a step with more than 1 is refused");
  set(Diagnostic::worst_step, "solver.worst_step_evaluations", "1",
      "most evaluations of the equations of motion in one communication step since initialization");
  set(Diagnostic::traced, "solver.traced_evaluations", "1",
      "evaluations of the equations of motion since initialization by a program that is made for the scene "
      "(solver.equations)");
  return signals;
}

}  // namespace gelenk
