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

// Reads unit, text and start, which inputs and element states have.
template <class Named>
void read_quantity(Fields& fields, Faults& faults, Named& named) {
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
               fields.done();
             });
}

void read_rates(const Json& section, Reader& reader) {
  const Field& field = ElementState::fields().front();
  for (ElementState& state : reader.scene.states) {
    const Json& value = section.at(state.name);
    const std::string path = "states." + text::printable(state.name);
    if (value.is_object() && value.contains("rate")) {
      read_field(value.at("rate"), path + ".rate", reader.faults, field, &state, {}, reader.names);
    } else if (value.is_string()) {
      read_field(value, path, reader.faults, field, &state, {}, reader.names);
    }
  }
}

namespace {

// Calls visit(name, type) for the entries of a section that has not been read.
template <class Visit>
void each_typed(const Json* section, Visit visit) {
  if (section == nullptr || !section->is_object()) return;
  for (const auto& [name, entry] : section->items()) {
    if (entry.is_object() && entry.contains("type") && entry.at("type").is_string())
      visit(name, entry.at("type").template get<std::string>());
  }
}

}  // namespace

FormulaNames names_in(const Json* joints, const Json* sensors, const Scene& scene) {
  FormulaNames out = formula_names(scene);
  const auto coordinates = std::make_shared<std::unordered_set<std::string>>();
  each_typed(joints, [&](const std::string& name, const std::string& type) {
    const JointKind* kind = find_joint_kind(type);
    if (kind != nullptr) add_coordinate_names(name, *kind, *coordinates);
  });
  each_typed(sensors, [&](const std::string& name, const std::string& type) {
    const std::span<const ElementKind> kinds = element_kinds<AnySensor>();
    const auto kind = std::ranges::find(kinds, type, &ElementKind::kind);
    if (kind != kinds.end()) add_sensor_names(name, *kind, *coordinates);
  });
  out.coordinates = coordinates;
  return out;
}

}  // namespace gelenk
