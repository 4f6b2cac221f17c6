// SPDX-License-Identifier: BSD-3-Clause
// Reads what expressions may name: the sections constants, inputs and states.
#include <algorithm>
#include <memory>

#include "joint/kinds.h"
#include "scene/formulas.h"
#include "scene/unit_system.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"

namespace gelenk {

void read_constants(const Json& section, Reader& reader) {
  each_entry(section, "constants", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               const double x = read_number(value, path, reader.faults, "").value_or(0);
               reader.scene.constants.push_back({name, x});
             });
}

namespace {

template <class Named>
void read_unit_and_text(Fields& fields, Faults& faults, Named& named) {
  if (const Json* unit = fields.find("unit")) {
    constexpr const char* expected = "a unit of SI, such as V, N.m or rad/s";
    named.unit = read_text(*unit, fields.path("unit"), faults, expected).value_or("");
    if (!is_unit(named.unit)) {
      faults.add(fields.path("unit"), text::quoted(named.unit), expected);
      named.unit.clear();
    }
  }
  if (const Json* text = fields.find("text"))
    named.text = read_text(*text, fields.path("text"), faults, "a text").value_or("");
}

// The same and the start value, which inputs and element states have.
template <class Named>
void read_quantity(Fields& fields, Faults& faults, Named& named) {
  read_unit_and_text(fields, faults, named);
  named.start = fields.number("start", 0, named.unit);
}

}  // namespace

void read_inputs(const Json& section, Reader& reader) {
  each_entry(section, "inputs", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               SceneInput& input = reader.scene.inputs.emplace_back();
               input.name = name;
               Fields fields(value, path, reader.faults, "a mapping with unit, start, text ({} for none of them)");
               if (!fields.valid()) return;
               read_quantity(fields, reader.faults, input);
               fields.done();
             });
}

void read_states(const Json& section, Reader& reader) {
  each_entry(section, "states", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               ElementState& state = reader.scene.states.emplace_back();
               state.name = name;
               if (value.is_string()) return;  // the rate alone
               Fields fields(value, path, reader.faults, "an expression, or a mapping with rate, start, unit");
               if (!fields.valid()) return;
               fields.require("rate", "an expression");
               read_quantity(fields, reader.faults, state);
               state.nominal = fields.number("nominal", 0, state.unit, Range::positive);
               fields.find("resets");  // read with the rate
               fields.done();
             });
}

void read_expressions(const Json& section, Reader& reader) {
  each_entry(section, "expressions", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               NamedExpression& of = reader.scene.expressions.emplace_back();
               of.name = name;
               if (value.is_string()) return;  // the value alone
               Fields fields(value, path, reader.faults, "an expression, or a mapping with value, unit, text");
               if (!fields.valid()) return;
               fields.require("value", "an expression");
               read_unit_and_text(fields, reader.faults, of);
               fields.done();
             });
}

namespace {

// Reads the formula of each entry, alone or under its key.
template <class Named>
void read_formulas(const Json* section, const std::string& name, std::vector<Named>& all, Reader& reader) {
  if (section == nullptr || !section->is_object()) return;
  const Field& field = Named::fields().front();
  const std::string key(field.name);
  for (Named& named : all) {
    if (!named.component.empty()) continue;
    const Json& value = section->at(named.name);
    const std::string path = name + "." + text::printable(named.name);
    if (value.is_object() && value.contains(key)) {
      read_field(value.at(key), path + "." + key, reader.faults, field, &named, {}, reader.names);
    } else if (value.is_string()) {
      read_field(value, path, reader.faults, field, &named, {}, reader.names);
    }
  }
}

// The texts of the named expressions, before these are read.
void add_texts(const Json* section, FormulaNames& names) {
  if (section == nullptr || !section->is_object()) return;
  for (const auto& [name, value] : section->items()) {
    const Json* const text = value.is_object() && value.contains("value") ? &value.at("value") : &value;
    if (text->is_string()) names.expressions.push_back({name, text->get<std::string>()});
    if (text->is_number()) names.expressions.push_back({name, text::number(text->get<double>())});
  }
}

}  // namespace

namespace {

void read_condition(const Json& value, const std::string& path, Reader& reader, StateReset& reset) {
  constexpr const char* expected = "a condition, such as x > 0.1";
  const auto text = read_text(value, path, reader.faults, expected);
  if (!text) return;
  reset.condition = *text;
  constexpr std::string_view before = "if(", after = ", 1, 0)";
  const Field& field = StateReset::fields().front();
  try {
    reset.when =
        Formula(std::string(before) + *text + std::string(after), variables_of(field, {}), reader.names, field.reads);
  } catch (const expression::SyntaxError& error) {
    const std::size_t place = std::min(error.place - std::min(error.place, before.size()), text->size());
    const expression::SyntaxError here(place, std::min(error.length, text->size() - place), error.what());
    reader.faults.add(path, text::quoted(*text), std::string(expected) + "; " + with_caret(here, *text));
  }
}

// Reads the list of {when, to} of a state.
void read_resets(const Json& value, const std::string& path, Reader& reader, ElementState& state) {
  constexpr const char* expected = "a list of {when, to}";
  if (!value.is_array()) return reader.faults.add(path, shown(value), expected);
  for (std::size_t i = 0; i < value.size(); ++i) {
    Fields fields(value[i], path + "[" + std::to_string(i + 1) + "]", reader.faults, "a mapping with when, to");
    if (!fields.valid()) return;
    StateReset& reset = state.resets.emplace_back();
    if (const Json* when = fields.require("when", "a condition"))
      read_condition(*when, fields.path("when"), reader, reset);
    if (const Json* to = fields.require("to", "an expression"))
      read_field(*to, fields.path("to"), reader.faults, StateReset::fields().back(), &reset, {}, reader.names);
    fields.done();
  }
}

}  // namespace

void read_formulas(const Json* states, const Json* expressions, Reader& reader) {
  read_formulas(states, "states", reader.scene.states, reader);
  for (ElementState& state : reader.scene.states) {
    if (states == nullptr || !states->is_object() || !state.component.empty()) continue;
    const Json& value = states->at(state.name);
    if (value.is_object() && value.contains("resets"))
      read_resets(value.at("resets"), "states." + text::printable(state.name) + ".resets", reader, state);
  }
  read_formulas(expressions, "expressions", reader.scene.expressions, reader);
}

FormulaNames names_in(const SectionsNotRead& sections, const Scene& scene) {
  FormulaNames out = formula_names(scene);
  out.expressions.clear();
  add_texts(sections.expressions, out);
  const auto coordinates = std::make_shared<std::unordered_set<std::string>>();
  each_typed(sections.joints, [&](const std::string& name, const std::string& type) {
    const JointKind* kind = find_joint_kind(type);
    if (kind != nullptr) add_coordinate_names(name, *kind, *coordinates);
  });
  each_typed(sections.sensors, [&](const std::string& name, const std::string& type) {
    const std::span<const ElementKind> kinds = element_kinds<AnySensor>();
    const auto kind = std::ranges::find(kinds, type, &ElementKind::kind);
    if (kind != kinds.end()) add_sensor_names(name, *kind, *coordinates);
  });
  out.coordinates = coordinates;
  if (sections.components != nullptr) add_component_names(*sections.components, sections.joints, scene, out);
  return out;
}

}  // namespace gelenk
