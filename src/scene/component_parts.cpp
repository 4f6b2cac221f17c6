// SPDX-License-Identifier: BSD-3-Clause
#include "scene/component_parts.h"

#include <map>
#include <memory>
#include <unordered_set>
#include <utility>

#include "element/components/component.h"
#include "expression/error.h"
#include "expression/tokens.h"
#include "scene/element_numbers.h"
#include "scene/formulas.h"
#include "util/text.h"

namespace gelenk {
namespace {

using Meanings = std::map<std::string, std::string, std::less<>>;

// A text with other names in place of those that have a meaning.
std::string renamed(std::string_view text, const Meanings& meanings) {
  std::string out;
  std::size_t done = 0;
  for (const expression::Token& token : expression::tokens(text)) {
    if (token.kind != expression::Token::Kind::name) continue;
    const auto found = meanings.find(token.text);
    if (found == meanings.end()) continue;
    out += text.substr(done, token.place - done);
    out += found->second;
    done = token.place + token.text.size();
  }
  return out + std::string(text.substr(done));
}

// The equations of a component with the names and units that they have in the scene.
class Parts {
 public:
  Parts(const Scene& scene, const Component& component)
      : component_(component), coordinate_(coordinate_of(scene, component)), equations_(equations_of(*component.is)) {
    each_number(kind_of(*component.is).fields, data_of(*component.is), [&](const Number& x) { add_name(x.path()); });
    for (const ComponentEquations::Quantity& input : equations_.inputs) add_name(input.name);
    for (const ComponentEquations::State& state : equations_.states) add_name(state.name);
    for (const ComponentEquations::Value& value : equations_.values) add_name(value.name);
    if (is_line()) {
      for (const auto& [own, output] : {std::pair{"length", length_output}, std::pair{"rate", rate_output}})
        meanings_[own] = named(output);
    }
    if (component.joints.empty()) return;
    const std::string joint = component.joints.front() + ".";
    for (const auto& [own, name] : {std::pair{"position", coordinate_.name}, std::pair{"speed", coordinate_.speed}}) {
      meanings_[own] = joint + std::string(name);
      variables_[std::string(name)] = joint + std::string(name);
    }
  }

  void add_to(FormulaNames& names) const {
    for (const ComponentEquations::Quantity& input : equations_.inputs) names.signals.push_back(named(input.name));
    for (const ComponentEquations::State& state : equations_.states) names.signals.push_back(named(state.name));
    for (const ComponentEquations::Value& value : equations_.values)
      names.expressions.push_back({named(value.name), text_of(value)});
    if (!is_line()) return;
    const auto coordinates = names.coordinates ? std::make_shared<std::unordered_set<std::string>>(*names.coordinates)
                                               : std::make_shared<std::unordered_set<std::string>>();
    add_sensor_names(component_.name, kind_of(*sensor_of_length()), *coordinates);
    names.coordinates = coordinates;
  }

  void add_to(Scene& scene, const FormulaNames& names) const {
    const auto read = [&](const Field& field, std::string text) {
      return Formula(std::move(text), variables_of(field, coordinate_), names, field.reads);
    };
    for (const ComponentEquations::Quantity& input : equations_.inputs)
      scene.inputs.push_back(filled<SceneInput>(input));
    for (const ComponentEquations::State& state : equations_.states) {
      ElementState& added = scene.states.emplace_back(filled<ElementState>(state));
      added.rate = read(ElementState::fields().front(), renamed(filled(state.rate), meanings_));
      added.start = state.start;
      added.nominal = state.nominal;
    }
    for (const ComponentEquations::Value& value : equations_.values) {
      NamedExpression& added = scene.expressions.emplace_back(filled<NamedExpression>(value));
      added.value = read(NamedExpression::fields().front(), text_of(value));
    }
    if (is_line()) {
      scene.sensors.push_back({between_points(), sensor_of_length(), component_.name});
      Force& force = scene.forces.emplace_back(Force{between_points(), force_along_line(), component_.name});
      const Field& tension = kind_of(*force.is).fields.front();
      formulas_of(tension, data_of(*force.is)).front() = read(tension, renamed(equations_.tension, meanings_));
    }
    if (equations_.effort.empty()) return;
    JointEffort& effort = scene.efforts.emplace_back();
    effort.component = component_.name;
    effort.joint = component_.joints.front();
    effort.value = read(JointEffort::fields().front(), renamed(filled(equations_.effort), meanings_));
  }

 private:
  bool is_line() const { return !equations_.tension.empty(); }
  ElementPlace between_points() const {
    return {.name = component_.name, .frames = component_.frames, .joints = {}, .coordinate = {}};
  }
  std::string filled(std::string_view text) const { return filled_in(text, component_, coordinate_); }
  std::string named(std::string_view own) const { return component_.name + "." + filled(own); }
  void add_name(std::string_view own) { meanings_[filled(own)] = named(own); }
  std::string text_of(const ComponentEquations::Value& value) const {
    return value.is_given ? renamed(value.value, variables_) : renamed(filled(value.value), meanings_);
  }
  template <class Named>
  Named filled(const ComponentEquations::Quantity& quantity) const {
    Named out;
    out.name = named(quantity.name);
    out.unit = unit_of(quantity.unit, coordinate_);
    out.text = component_.name + ": " + filled(quantity.text);
    out.component = component_.name;
    return out;
  }

  const Component& component_;
  Coordinate coordinate_;
  ComponentEquations equations_;
  Meanings meanings_;   // of the names of the component
  Meanings variables_;  // of the coordinate and the speed in the user's expressions
};

}  // namespace

void add_component_constants(const Scene& scene, std::vector<FormulaNames::Constant>& constants) {
  for (const Component& component : scene.components) {
    const Coordinate coordinate = coordinate_of(scene, component);
    each_number(kind_of(*component.is).fields, data_of(*component.is), [&](const Number& x) {
      constants.push_back({component.name + "." + x.path(), *x.value * scene.units.size_of(x.unit(coordinate))});
    });
  }
}

void add_component_names(const Scene& scene, FormulaNames& names) {
  add_component_constants(scene, names.constants);
  for (const Component& component : scene.components) Parts(scene, component).add_to(names);
}

void add_component_parts(Scene& scene, const FormulaNames& names,
                         const std::function<void(const Component&, const std::string&)>& fault) {
  for (const Component& component : scene.components) {
    if (!text::is_identifier(component.name)) continue;  // reported with the names
    try {
      Parts(scene, component).add_to(scene, names);
    } catch (const expression::SyntaxError& error) {
      fault(component, error.what());
    }
  }
}

std::vector<DrivenJoint> driven_joints(const Scene& scene) {
  std::vector<DrivenJoint> out;
  for (const Motor& motor : scene.motors)
    out.push_back({motor.joints.front(), inertia_of(*motor.is), "motors." + motor.name});
  for (const Component& component : scene.components) {
    if (component.joints.empty()) continue;
    out.push_back({component.joints.front(), inertia_of(*component.is), "components." + component.name});
  }
  return out;
}

}  // namespace gelenk
