// SPDX-License-Identifier: BSD-3-Clause
// Reads motors, forces, constraints and sensors according to the registry of their kinds.
#include <algorithm>
#include <map>
#include <type_traits>
#include <utility>

#include "scene/component_parts.h"
#include "scene/formulas.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"

namespace gelenk {
namespace {

std::string read_joint_name(Fields& fields, const Port& port, Reader& reader) {
  const std::string field(port.name);
  const char* expected = "the name of a joint";
  const Json* value = port.optional ? fields.find(field) : fields.require(field, expected);
  if (value == nullptr) return {};
  const auto name = read_text(*value, fields.path(field), reader.faults, expected);
  if (!name || reader.joints.empty()) return {};  // no joints: reported already
  if (std::ranges::find(reader.joints, *name) != reader.joints.end()) return *name;
  reader.faults.add(fields.path(field), text::quoted(*name), text::one_of(*name, reader.joints, "joints"));
  return {};
}

// Reads the name of a coordinate; by default the only coordinate of a joint that has one. Empty: of what is not
// prescribed, that one.
std::string read_coordinate(Fields& fields, const Port& port, const std::string& joint, Reader& reader) {
  const JointKind* kind = kind_of_joint(reader.scene, joint);
  const Json* value = fields.find("coordinate");
  std::vector<std::string> names;
  if (kind != nullptr) {
    for (const Quantity& q : kind->q) names.emplace_back(q.name);
  }
  if (kind != nullptr && port.fits != nullptr && !port.fits(*kind)) return {};  // reported with the joint
  const std::string path = fields.path("coordinate");
  if (value == nullptr) {
    if (names.size() <= 1) return names.empty() || !port.is_prescribed ? std::string() : names[0];
    reader.faults.add(path, "nothing", text::one_of({}, names, "coordinates of " + joint));
    return {};
  }
  const auto name = read_text(*value, path, reader.faults, "the name of a coordinate");
  if (!name || kind == nullptr) return {};
  if (std::ranges::find(names, *name) != names.end())
    return names.size() == 1 && !port.is_prescribed ? std::string() : *name;
  reader.faults.add(path, text::quoted(*name), text::one_of(*name, names, "coordinates of " + joint));
  return {};
}

BodyFrame read_frame(Fields& fields, const Port& port, Reader& reader) {
  BodyFrame frame;
  if (port.name.empty()) {
    const Json* body = fields.require("body", "the name of a body");
    frame.body = body != nullptr ? read_body_name(*body, fields.path("body"), reader.faults, reader.bodies) : "";
    if (port.kind != Port::Kind::body) frame.X_BF = read_pose(fields, port.kind == Port::Kind::frame);
    return frame;
  }
  const std::string key(port.name);
  const bool turned = port.kind == Port::Kind::frame;
  const char* expected =
      turned ? "{body, position, rotation} or the name of a body" : "{body, position} or the name of a body";
  const Json* value = port.optional ? fields.find(key) : fields.require(key, expected);
  if (value != nullptr) return read_body_frame(*value, fields.path(key), reader.faults, reader.bodies, turned);
  if (!port.optional) frame.body.clear();
  return frame;
}

// Reads the names of two surfaces.
std::vector<std::string> read_surfaces(Fields& fields, const Port& port) {
  const std::string key(port.name);
  constexpr const char* expected = "the names of two surfaces, such as [wood, steel]";
  const Json* value = fields.require(key, expected);
  if (value == nullptr) return {"", ""};
  if (!value->is_array() || value->size() != 2) {
    fields.faults().add(fields.path(key), shown(*value), expected);
    return {"", ""};
  }
  std::vector<std::string> out;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string path = fields.path(key) + "[" + std::to_string(i + 1) + "]";
    out.push_back(read_text((*value)[i], path, fields.faults(), "the name of a surface").value_or(""));
  }
  return out;
}

void read_ports(Fields& fields, const ElementKind& kind, Reader& reader, ElementPlace& element) {
  for (const Port& port : kind.ports) {
    if (port.kind == Port::Kind::surfaces) {
      element.surfaces = read_surfaces(fields, port);
      continue;
    }
    if (port.is_frame()) {
      element.frames.push_back(read_frame(fields, port, reader));
      continue;
    }
    element.joints.push_back(read_joint_name(fields, port, reader));
    if (port.has_coordinate) element.coordinate = read_coordinate(fields, port, element.joints.back(), reader);
  }
}

// Returns the expected contents of an entry, for entries that are not a mapping.
std::string mapping_of(const Section& section, std::span<const ElementKind> kinds) {
  std::vector<std::string> names;
  for (const ElementKind& kind : kinds) {
    if (kind.kind != section.default_type) continue;
    for (const Port& port : kind.ports) names.emplace_back(port.name);
    for (const Field& field : kind.fields) names.emplace_back(field.name);
  }
  return "a mapping with " + (names.empty() ? "type" : text::list(names));
}

std::vector<std::string> element_kind_names(std::span<const ElementKind> kinds) {
  std::vector<std::string> names;
  for (const ElementKind& kind : kinds) names.emplace_back(kind.kind);
  return names;
}

template <class Any>
constexpr bool section_has_states = std::is_same_v<Any, AnyComponent>;

template <class Any>
void read_section(const Json& section, const Section& of, Reader& reader, std::vector<Element<Any>>& out) {
  const std::span<const ElementKind> kinds = element_kinds<Any>();
  const std::vector<std::string> names = element_kind_names(kinds);
  const std::string expected = mapping_of(of, kinds);
  each_entry(section, std::string(of.name), reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               const std::size_t before = reader.faults.count();
               Fields fields(value, path, reader.faults, expected);
               const std::string type = fields.choice("type", names, std::string(of.default_type));
               if (type.empty()) {
                 reader.suspect_names.insert(name);
                 return;
               }
               const auto n = static_cast<std::size_t>(std::ranges::find(names, type) - names.begin());
               Element<Any> element;
               element.name = name;
               element.is = make_element<Any>(n);
               read_ports(fields, kinds[n], reader, element);
               const Coordinate coordinate = coordinate_of(reader.scene, element);
               read_fields(fields, kinds[n].fields, data_of(*element.is), coordinate, reader.names);
               if constexpr (section_has_states<Any>) {
                 if (const Json* start = fields.find("start")) reader.starts[name] = *start;
               }
               fields.done();
               if (reader.faults.count() == before) check_numbers(element, path, coordinate, reader.faults);
               out.push_back(std::move(element));
             });
}

}  // namespace

void add_component_names(const Json& components, const Json* joints, const Scene& scene, FormulaNames& names) {
  if (!components.is_object()) return;
  Scene seen;  // of which nothing but the components and the types of joints is known
  Faults ignored(scene.file);
  SuspectNames suspect_names;
  Reader reader{seen, ignored, {}, {}, suspect_names, {}};
  reader.names.tables = names.tables;
  reader.names.constants = names.constants;
  reader.names.any = true;
  each_typed(joints, [&](const std::string& name, const std::string& type) {
    if (find_joint_kind(type) == nullptr) return;
    Joint& joint = seen.joints.emplace_back();
    joint.name = name;
    joint.type = type;
    reader.joints.push_back(name);
  });
  read_section(components, components_section, reader, seen.components);
  std::erase_if(seen.components, [](const Component& component) {
    return std::ranges::any_of(component.joints, [](const std::string& joint) { return joint.empty(); });
  });
  add_component_names(seen, names);
}

namespace {

// Reads the start values of the states of components: {i: 0.5}.
void read_starts(Reader& reader) {
  for (const auto& [component, value] : reader.starts) {
    const std::string path = "components." + text::printable(component) + ".start";
    if (!value.is_object()) {
      reader.faults.add(path, shown(value), "a mapping from states to their start values");
      continue;
    }
    std::map<std::string, ElementState*> states;
    std::vector<std::string> names;
    for (ElementState& state : reader.scene.states) {
      if (state.component != component) continue;
      names.push_back(own_name(state));
      states[names.back()] = &state;
    }
    for (const auto& [name, start] : value.items()) {
      const auto found = states.find(name);
      if (found == states.end()) {
        reader.faults.add(path, text::quoted(name), text::one_of(name, names, "states of " + component));
        continue;
      }
      const std::string at = path + "." + name;
      found->second->start = read_number(start, at, reader.faults, found->second->unit).value_or(0);
    }
  }
}

}  // namespace

namespace {

// Components come after all whose forces their signals may name. Which forces there are is known only if that is sound.
void know_forces(Reader& reader) {
  if (reader.faults.count() > 0)
    reader.names.any = true;
  else
    reader.names.forces = force_names(reader.scene);
}

}  // namespace

void read_elements(Fields& sections, Reader& reader) {
  each_section(reader.scene, [&](const Section& section, auto& elements) {
    const Json* value = sections.find(std::string(section.name));
    if (value == nullptr) return;
    if (section.name == components_section.name) know_forces(reader);
    read_section(*value, section, reader, elements);
  });
  if (reader.faults.count() > 0) return;
  add_component_parts(reader.scene, reader.names, [&](const Component& component, const std::string& found) {
    reader.faults.add("components." + text::printable(component.name), found.substr(std::string_view("found ").size()),
                      "signals of which its equations can be made");
  });
  read_starts(reader);
}

}  // namespace gelenk
