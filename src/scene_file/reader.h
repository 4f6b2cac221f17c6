// SPDX-License-Identifier: BSD-3-Clause
// Readers of the sections of a scene file: each reads one section into the scene and adds errors to its faults.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "check/check.h"
#include "scene/scene.h"
#include "scene_file/advice.h"
#include "scene_file/frames.h"
#include "scene_file/json_fields.h"
#include "util/text.h"

namespace gelenk {

// State shared by the readers of the sections.
struct Reader {
  Scene& scene;
  Faults& faults;
  std::vector<std::string> bodies;  // names, ground first; empty if the section could not be read
  std::vector<std::string> joints;
  SuspectNames& suspect_names;
  FormulaNames names;                    // what expressions may name
  std::map<std::string, Json> starts{};  // of the states of components, by their name
};

// Reads and checks the whole tree. Throws SceneError with all errors, including those in `faults` before the call.
Scene scene_from_tree(const Json& tree, const std::string& file, Faults& faults);

// Reads {name: number, ...} and {name: {unit, start, text}, ...}, which expressions may name.
void read_constants(const Json& section, Reader& reader);
// Reads {name: {x, values, ...}, ...}, tables that expressions look up.
void read_tables(const Json& section, Reader& reader);
void read_inputs(const Json& section, Reader& reader);
// Reads {name: "rate", ...} or {name: {rate, start, unit, nominal, text}, ...}, and {name: "value", ...} or {name:
// {value, unit, text}, ...}: all but the formulas, then these, which may name each other.
void read_states(const Json& section, Reader& reader);
void read_expressions(const Json& section, Reader& reader);
void read_formulas(const Json* states, const Json* expressions, Reader& reader);
// What expressions may name: of the scene as far as it has been read, and of these sections.
struct SectionsNotRead {
  const Json *joints, *sensors, *expressions, *components;
};
FormulaNames names_in(const SectionsNotRead& sections, const Scene& scene);
void read_bodies(const Json& section, Reader& reader);
// Reads the shapes of the ground: {shapes: {...}}.
void read_ground(const Json& section, Reader& reader);
// Reads {name: {sphere: 0.1, position: [..], surface: wood}, ...}. path: that of the mapping.
std::vector<BodyShape> read_shapes(const Json& value, const std::string& path, Faults& faults);
void read_joints(const Json& section, Reader& reader);
// What expressions may name of components (scene/component_parts.h) that have not been read. joints: their section.
void add_component_names(const Json& components, const Json* joints, const Scene& scene, FormulaNames& names);
// Calls visit(name, type) for the entries of a section that has not been read; null: of none.
template <class Visit>
void each_typed(const Json* section, Visit visit) {
  if (section == nullptr || !section->is_object()) return;
  for (const auto& [name, entry] : section->items()) {
    if (entry.is_object() && entry.contains("type") && entry.at("type").is_string())
      visit(name, entry.at("type").template get<std::string>());
  }
}
// Reads all sections of elements, and adds the parts of components.
void read_elements(Fields& sections, Reader& reader);
void read_parameters(const Json& section, Reader& reader);
void read_outputs(const Json& section, Reader& reader);
void read_assembly(const Json& section, Reader& reader);
void read_experiment(const Json& section, Reader& reader);
void read_solver(const Json& section, Reader& reader);

// Reads start values by the names of the joint's coordinates and velocities; arrays as a whole: Q: [x, y, z, w].
void read_start(const Json& value, const std::string& path, Faults& faults, Joint& joint);

// Calls read(name, value, path) for every entry of a section {name: value, ...}.
template <class Read>
void each_entry(const Json& section, const std::string& name, Faults& faults, Read read) {
  if (!section.is_object()) {
    faults.add(
        name, shown(section),
        "a mapping from names to " + name + (section.is_null() ? " ({} for none)" : "") + advice::on_section(section));
    return;
  }
  for (const auto& [key, value] : section.items()) read(key, value, name + "." + text::printable(key));
}

}  // namespace gelenk
