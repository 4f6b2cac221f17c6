// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/read.h"

#include <algorithm>
#include <utility>

#include "check/warnings.h"
#include "scene/formulas.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Checks the version of the format; a file of another version is not read any further.
bool version_is_supported(Fields& fields) {
  const std::string expected = std::to_string(scene_version) + ", the version of the scene format";
  const Json* version = fields.require("gelenk", expected);
  if (version == nullptr) return true;  // reported; the rest can still be checked
  if (version->is_number() && version->get<double>() == scene_version) return true;
  fields.faults().add("gelenk", shown(*version), expected + " that this Gelenk reads");
  return false;
}

// A text that files and XML can contain, of 1 to `longest` characters. U+FFFE and U+FFFF (EF BF BE and EF BF BF in
// UTF-8) are no characters.
bool is_printable(const std::string& text, std::size_t longest, bool lines) {
  const auto printable = [&](unsigned char c) {
    return (c >= 0x20 && c != 0x7f) || (lines && (c == '\n' || c == '\t'));
  };
  const auto size = std::ranges::count_if(text, [](unsigned char c) { return (c & 0xc0U) != 0x80; });
  return !text.empty() && static_cast<std::size_t>(size) <= longest && std::ranges::all_of(text, printable) &&
         text.find("\xef\xbf\xbe") == std::string::npos && text.find("\xef\xbf\xbf") == std::string::npos;
}

std::string read_name(Fields& fields, const std::string& otherwise) {
  const Json* value = fields.find("name");
  if (value == nullptr) return otherwise;
  constexpr const char* expected = "a name of 1 to 200 printable characters";
  const auto name = read_text(*value, "name", fields.faults(), expected);
  if (!name) return otherwise;
  if (is_printable(*name, 200, false)) return *name;
  fields.faults().add("name", text::quoted(*name), expected);
  return otherwise;
}

void read_metadata(Fields& fields, Metadata& metadata) {
  const std::string expected = "a text of 1 to " + std::to_string(max_metadata_size) + " printable characters";
  for (const MetadataKey& key : metadata_keys) {
    const std::string name(key.name);
    const Json* value = fields.find(name);
    if (value == nullptr) continue;
    const bool number = value->is_number() || value->is_boolean();
    const auto text = read_text(*value, name, fields.faults(), expected + (number ? "; put it in quotes" : ""));
    if (!text) continue;
    if (is_printable(*text, max_metadata_size, true)) {
      metadata.*key.text = *text;
    } else {
      fields.faults().add(name, text::quoted(*text), expected);
    }
  }
}

// Uniform gravity, or a mapping with a field.
void read_gravity(const Json& value, Fields& fields, Reader& reader) {
  constexpr const char* known[] = {"law", "mu", "center", "uniform"};
  const auto has = [&](const char* key) { return value.contains(key); };
  if (!value.is_object() || (!value.empty() && std::ranges::none_of(known, has))) {
    reader.scene.gravity = fields.vector("gravity", "m/s2");
    return;
  }
  const std::size_t before = reader.faults.count();
  Fields inner(value, "gravity", reader.faults, "a mapping with law, or mu and center");
  reader.scene.gravity = inner.vector("uniform", "m/s2");
  GravityField& field = reader.scene.gravity_field.emplace();
  read_fields(inner, GravityField::fields(), &field, {}, reader.names);
  inner.done();
  const bool has_law = field.law.front().is_given();
  if (has_law && has("center"))
    reader.faults.add("gravity.center", "a center of a law", "mu and center, or a law alone");
  if (has_law == field.is_central() && reader.faults.count() == before)
    reader.faults.add("gravity", has_law ? "law and mu" : "neither law nor mu", "either law, or mu and center");
}

std::vector<std::string> keys(const Json* section) {
  std::vector<std::string> names;
  if (section == nullptr || !section->is_object()) return names;
  for (const auto& [key, value] : section->items()) names.push_back(key);
  return names;
}

using Read = void (*)(const Json&, Reader&);

// Finds a section that must have entries.
const Json* required_section(Fields& fields, const std::string& name, const std::string& expected) {
  const Json* section = fields.require(name, expected);
  if (section != nullptr && section->is_object() && section->empty()) fields.faults().add(name, "nothing", expected);
  return section;
}

// The rates of states and the named expressions, after all that these may name. Which forces there are is known only if
// that is sound; otherwise mistakes in expressions are reported when all others have been mended.
void read_named(const Json* states, const Json* expressions, Reader& reader) {
  if (reader.faults.count() == 0) {
    reader.names.forces = force_names(reader.scene);
    return read_formulas(states, expressions, reader);
  }
  Faults ignored(reader.scene.file);
  Reader silent{reader.scene, ignored, {}, {}, reader.suspect_names, reader.names};
  read_formulas(states, expressions, silent);
}

void read_sections(Fields& fields, Scene& scene, SuspectNames& suspect_names) {
  const Json* gravity = fields.find("gravity");
  const Json* bodies = required_section(fields, "bodies", "at least one body");
  const Json* joints = required_section(fields, "joints", "at least one joint");
  Reader reader{scene, fields.faults(), {}, keys(joints), suspect_names, {}};
  if (const Json* constants = fields.find("constants")) read_constants(*constants, reader);
  if (const Json* tables = fields.find("tables")) read_tables(*tables, reader);
  if (const Json* inputs = fields.find("inputs")) read_inputs(*inputs, reader);
  const Json* states = fields.find("states");
  const Json* expressions = fields.find("expressions");
  if (states != nullptr) read_states(*states, reader);
  if (expressions != nullptr) read_expressions(*expressions, reader);
  reader.names = names_in({.joints = joints,
                           .sensors = fields.peek("sensors"),
                           .expressions = expressions,
                           .components = fields.peek("components")},
                          scene);
  if (gravity != nullptr) read_gravity(*gravity, fields, reader);
  if (bodies != nullptr && bodies->is_object()) reader.bodies = {ground};
  for (std::string& name : keys(bodies)) reader.bodies.push_back(std::move(name));
  if (bodies != nullptr) read_bodies(*bodies, reader);
  if (const Json* shapes = fields.find(ground)) read_ground(*shapes, reader);
  if (joints != nullptr) read_joints(*joints, reader);
  read_elements(fields, reader);
  read_named(states, expressions, reader);
  constexpr std::pair<const char*, Read> rest[] = {{"parameters", read_parameters},
                                                   {"outputs", read_outputs},
                                                   {"assembly", read_assembly},
                                                   {"experiment", read_experiment},
                                                   {"solver", read_solver}};
  for (const auto& [name, read] : rest) {
    if (const Json* section = fields.find(name)) read(*section, reader);
  }
}

}  // namespace

Scene scene_from_tree(const Json& tree, const std::string& file, Faults& faults) {
  Scene scene;
  scene.file = file;
  Fields fields(tree, "", faults, "a mapping with gelenk, bodies, joints");
  if (fields.valid() && version_is_supported(fields)) {
    SuspectNames suspect_names;
    scene.name = read_name(fields, scene.name);
    read_metadata(fields, scene.metadata);
    read_sections(fields, scene, suspect_names);
    fields.done();
    find_faults(scene, faults, suspect_names);
  }
  faults.raise();
  return scene;
}

Scene read_scene_json(std::string_view text, const std::string& file, std::vector<std::string>& warnings) {
  Faults faults(file);
  const Json tree = parse_json(text, faults.file(), faults);
  Scene scene = scene_from_tree(tree, file, faults);
  find_warnings(scene, faults);
  warnings.insert(warnings.end(), faults.warnings().begin(), faults.warnings().end());
  return scene;
}

Scene read_scene_json(std::string_view text, const std::string& file) {
  Faults faults(file);
  const Json tree = parse_json(text, faults.file(), faults);
  return scene_from_tree(tree, file, faults);
}

Scene checked(const Scene& scene) {
  Scene out = read_scene_json(write_scene_json(scene), scene.file);
  for (std::size_t j = 0; j < out.joints.size(); ++j) out.joints[j].start.q_set = scene.joints[j].start.q_set;
  return out;
}

}  // namespace gelenk
