// SPDX-License-Identifier: BSD-3-Clause
#include "scene/formulas.h"

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "scene/component_parts.h"
#include "scene/element_numbers.h"
#include "scene/motions.h"

namespace gelenk {
namespace {

// Calls visit(formula, field, coordinate) for each expression among these fields that is given.
template <class Visit>
void each_of(std::span<const Field> fields, void* element, const Coordinate& coordinate, Visit visit) {
  if (element == nullptr) return;
  for (const Field& field : fields) {
    if (field.type == Field::Type::group) each_of(field.inner(), field.in(element), coordinate, visit);
    for (Formula& formula : formulas_of(field, element)) {
      if (formula.is_given()) visit(formula, field, coordinate);
    }
  }
}

// The same for all expressions, with place(), that of their element, which is that of a joint for forces along it.
template <class Visit>
void each_formula(Scene& scene, Visit visit) {
  // Of what has a name, but no place.
  const auto of_none = [&](const std::string& name, auto& of) {
    const auto nowhere = [&] { return ElementPlace{.name = name, .frames = {}, .joints = {}, .coordinate = {}}; };
    each_of(of.fields(), &of, {},
            [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, nowhere); });
  };
  for (ElementState& state : scene.states) of_none(state.name, state);
  for (ElementState& state : scene.states) {
    for (StateReset& reset : state.resets) of_none(state.name, reset);
  }
  for (NamedExpression& of : scene.expressions) of_none(of.name, of);
  for (Joint& joint : scene.joints) {
    const JointKind& kind = *find_joint_kind(joint.type);
    const auto place = [&] {
      return ElementPlace{.name = joint.name, .frames = {}, .joints = {joint.name}, .coordinate = {}};
    };
    for (std::size_t i = 0; i < joint.along.size(); ++i) {
      for (const JointForceKind& force : joint_force_kinds()) {
        each_of(force.fields, force.find(*joint.along[i]), coordinate_of(kind, static_cast<int>(i)),
                [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, place); });
      }
    }
  }
  for (JointEffort& effort : scene.efforts) {
    const auto place = [&] {
      return ElementPlace{.name = effort.component, .frames = {}, .joints = {effort.joint}, .coordinate = {}};
    };
    visit(effort.value, JointEffort::fields().front(), coordinate_of(kind_of_joint(scene, effort.joint)), place);
  }
  if (scene.gravity_field) {
    const auto everywhere = [&] {
      ElementPlace place{.name = "gravity", .frames = {}, .joints = {}, .coordinate = {}};
      for (const Body& body : scene.bodies) place.frames.push_back({.body = body.name, .X_BF = {}});
      return place;
    };
    each_of(GravityField::fields(), &*scene.gravity_field, {},
            [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, everywhere); });
  }
  each_section(scene, [&](const Section&, auto& elements) {
    for (auto& element : elements) {
      const auto place = [&]() -> const ElementPlace& { return element; };
      each_of(kind_of(*element.is).fields, data_of(*element.is), coordinate_of(scene, element),
              [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, place); });
    }
  });
}

bool names(const Formula& formula, std::string_view signal) {
  return std::ranges::find(formula.signal_names(), signal) != formula.signal_names().end();
}

}  // namespace

void add_coordinate_names(std::string_view joint, const JointKind& kind, std::unordered_set<std::string>& out) {
  const auto add = [&](std::string_view quantity) { out.insert(std::string(joint) + "." + std::string(quantity)); };
  for (int i = 0; i < kind.nq; ++i) {
    if (!kind.is_of_quaternion(i)) add(kind.q[static_cast<std::size_t>(i)].name);
  }
  for (const Quantity& speed : kind.v) add(speed.name);
}

FormulaNames formula_names(const Scene& scene) {
  FormulaNames out;
  out.constants = scene.constants;
  add_component_constants(scene, out.constants);
  for (const SceneTable& table : scene.tables) out.tables.push_back({table.name, table.is});
  for (const SceneInput& input : scene.inputs) out.signals.push_back(input.name);
  for (const ElementState& state : scene.states) out.signals.push_back(state.name);
  for (const NamedExpression& of : scene.expressions)
    out.expressions.push_back({of.name, std::string(of.value.text())});
  const auto coordinates = std::make_shared<std::unordered_set<std::string>>();
  for (const Joint& joint : scene.joints) add_coordinate_names(joint.name, *find_joint_kind(joint.type), *coordinates);
  for (const Sensor& sensor : scene.sensors) add_sensor_names(sensor.name, kind_of(*sensor.is), *coordinates);
  out.coordinates = coordinates;
  const auto reads_forces = [](const NamedExpression& of) { return of.value.reads_forces(); };
  if (std::ranges::any_of(scene.expressions, reads_forces) || first_with_rate_of_forces(scene) != nullptr)
    out.forces = force_names(scene);
  return out;
}

std::shared_ptr<const std::unordered_set<std::string>> force_names(const Scene& scene) {
  const auto out = std::make_shared<std::unordered_set<std::string>>();
  for (const Signal& signal : force_signals(scene)) out->insert(signal.name);
  return out;
}

std::vector<Signal> force_signals(const Scene& scene) {
  std::vector<Signal> out = output_signals(scene);
  std::erase_if(out, [&](const Signal& signal) {
    if (signal.section == sections::states || signal.section == sections::expressions) return true;
    if (signal.section == sections::contacts) return true;
    if (signal.section == sections::sensors &&
        kind_of(*scene.sensors[static_cast<std::size_t>(signal.element)].is).of_whole)
      return true;
    return signal.stage != Stage::acceleration;
  });
  return out;
}

std::optional<JointQuantity> find_coordinate(const Scene& scene, std::string_view name) {
  const std::size_t point = name.find('.');
  const auto joint = std::ranges::find(scene.joints, name.substr(0, point), &Joint::name);
  if (point == name.npos || joint == scene.joints.end()) return std::nullopt;
  const JointKind& kind = *find_joint_kind(joint->type);
  const auto j = static_cast<int>(joint - scene.joints.begin());
  for (int level = 0; level < 2; ++level) {
    const std::span<const Quantity> among = level == 0 ? kind.q : kind.v;
    const auto found = std::ranges::find(among, name.substr(point + 1), &Quantity::name);
    if (found == among.end()) continue;
    return JointQuantity{
        .joint = j, .component = static_cast<int>(found - among.begin()), .is_rate = level == 1, .unit = found->unit};
  }
  return std::nullopt;
}

void renew_formulas(Scene& scene) {
  const FormulaNames names = formula_names(scene);
  each_formula(scene, [&](Formula& formula, const Field& field, const Coordinate& coordinate, const auto&) {
    formula.renew(variables_of(field, coordinate), names);
  });
}

void add_sensor_names(std::string_view sensor, const ElementKind& kind, std::unordered_set<std::string>& out) {
  if (kind.of_whole || kind.reads_reaction) return;
  for (const SignalGroup& group : kind.outputs) {
    if (group.stage == Stage::acceleration) continue;
    const std::string name = std::string(sensor) + "." + std::string(group.name);
    if (group.size == 0) out.insert(name);
    for (int i = 1; i <= group.size; ++i) out.insert(name + "[" + std::to_string(i) + "]");
  }
}

std::optional<SensorOutput> find_sensor_output(const Scene& scene, std::string_view name) {
  const std::size_t point = name.find('.');
  const auto sensor = std::ranges::find(scene.sensors, name.substr(0, point), &Sensor::name);
  if (point == name.npos || sensor == scene.sensors.end()) return std::nullopt;
  const std::string_view of = name.substr(point + 1, name.find('[') - point - 1);
  const std::span<const SignalGroup> groups = kind_of(*sensor->is).outputs;
  const auto group = std::ranges::find(groups, of, &SignalGroup::name);
  const std::size_t index = name.find('[');
  const int component =
      index == name.npos ? 0
                         : static_cast<int>(std::strtol(std::string(name.substr(index + 1)).c_str(), nullptr, 10)) - 1;
  return SensorOutput{.sensor = static_cast<int>(sensor - scene.sensors.begin()),
                      .group = static_cast<int>(group - groups.begin()),
                      .component = component};
}

bool couples(const Scene& scene, const Formula& formula) {
  return std::ranges::any_of(formula.signal_names(), [&](const std::string& name) {
    if (std::ranges::find(scene.inputs, name, &SceneInput::name) != scene.inputs.end()) return false;
    return name.find('.') != name.npos ||
           std::ranges::find(scene.states, name, &ElementState::name) != scene.states.end();
  });
}

std::vector<FormulaReader> formula_readers(const Scene& scene) {
  std::vector<FormulaReader> out;
  // NOLINTNEXTLINE(*-const-cast): only read
  each_formula(const_cast<Scene&>(scene),
               [&](const Formula& formula, const Field&, const Coordinate&, const auto& place) {
                 const std::span<const std::string> names = formula.signal_names();
                 if (!names.empty()) out.push_back({place(), {names.begin(), names.end()}});
               });
  return out;
}

std::unordered_set<std::string> named_of_motion(const Scene& scene) {
  std::unordered_set<std::string> out;
  for (const FormulaReader& reader : formula_readers(scene)) {
    for (const std::string& signal : reader.signals) {
      if (const std::size_t point = signal.find('.'); point != signal.npos) out.insert(signal.substr(0, point));
    }
  }
  return out;
}

const ElementState* first_with_resets(const Scene& scene) {
  const auto found = std::ranges::find_if(scene.states, [](const ElementState& of) { return !of.resets.empty(); });
  return found == scene.states.end() ? nullptr : &*found;
}

const ElementState* first_with_rate_of_forces(const Scene& scene) {
  const auto found = std::ranges::find_if(scene.states, [](const ElementState& of) { return of.rate.reads_forces(); });
  return found == scene.states.end() ? nullptr : &*found;
}

bool reads_time(const Scene& scene) {
  const auto follows_time = [](const Constraint& of) {
    const Motion* const motion = find_motion_of_signals(of);
    return motion != nullptr && names_variable(motion->law_of_signals(), 0);
  };
  return !readers_of(scene, time_signal).empty() || std::ranges::any_of(scene.constraints, follows_time);
}

double size_of(const ElementState& state, const UnitSystem& units) {
  return state.nominal > 0 ? state.nominal : units.size_of(state.unit);
}

std::vector<ElementPlace> readers_of(const Scene& scene, std::string_view signal) {
  std::vector<ElementPlace> out;
  // NOLINTNEXTLINE(*-const-cast): only read
  each_formula(const_cast<Scene&>(scene),
               [&](const Formula& formula, const Field&, const Coordinate&, const auto& place) {
                 if (names(formula, signal)) out.push_back(place());
               });
  return out;
}

}  // namespace gelenk
