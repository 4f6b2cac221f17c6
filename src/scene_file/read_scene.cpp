// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/read.h"

#include <algorithm>
#include <utility>

#include "check/warnings.h"
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

std::string read_name(Fields& fields, const std::string& otherwise) {
  const Json* value = fields.find("name");
  if (value == nullptr) return otherwise;
  constexpr const char* expected = "a name of 1 to 200 printable characters";
  const auto name = read_text(*value, "name", fields.faults(), expected);
  if (!name) return otherwise;
  const bool printable = std::ranges::all_of(*name, [](unsigned char c) { return c >= 0x20 && c != 0x7f; });
  if (!name->empty() && name->size() <= 200 && printable) return *name;
  fields.faults().add("name", text::quoted(*name), expected);
  return otherwise;
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

void read_sections(Fields& fields, Scene& scene, SuspectNames& suspect_names) {
  const Json* bodies = required_section(fields, "bodies", "at least one body");
  const Json* joints = required_section(fields, "joints", "at least one joint");
  Reader reader{scene, fields.faults(), {}, keys(joints), suspect_names};
  if (bodies != nullptr && bodies->is_object()) reader.bodies = {ground};
  for (std::string& name : keys(bodies)) reader.bodies.push_back(std::move(name));
  if (bodies != nullptr) read_bodies(*bodies, reader);
  if (const Json* shapes = fields.find(ground)) read_ground(*shapes, reader);
  if (joints != nullptr) read_joints(*joints, reader);
  read_elements(fields, reader);
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
    scene.gravity = fields.vector("gravity", "m/s2");
    read_sections(fields, scene, suspect_names);
    fields.done();
    find_faults(scene, faults, suspect_names);
  }
  faults.raise();
  find_warnings(scene, faults);
  return scene;
}

Scene read_scene_json(std::string_view text, const std::string& file, std::vector<std::string>& warnings) {
  Faults faults(file);
  const Json tree = parse_json(text, faults.file(), faults);
  Scene scene = scene_from_tree(tree, file, faults);
  warnings.insert(warnings.end(), faults.warnings().begin(), faults.warnings().end());
  return scene;
}

Scene read_scene_json(std::string_view text, const std::string& file) {
  std::vector<std::string> warnings;
  return read_scene_json(text, file, warnings);
}

Scene checked(const Scene& scene) { return read_scene_json(write_scene_json(scene), scene.file); }

}  // namespace gelenk
