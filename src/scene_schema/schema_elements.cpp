// SPDX-License-Identifier: BSD-3-Clause
// Sections of elements in the JSON Schema, generated from the descriptions in the registry of elements.
#include <cctype>
#include <utility>

#include "scene_file/element_fields.h"
#include "scene_schema/schema_parts.h"
#include "util/text.h"

namespace gelenk::schema {
namespace {

// Capitalizes the first letter.
std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string text_of(std::string_view text, const Coordinate* coordinate) {
  return sentence(about_any(text, coordinate));
}

// Returns the unit of a field; of an unknown coordinate both units.
std::string unit_for(const Field& field, const Coordinate* coordinate) {
  if (coordinate != nullptr) return spelled(unit_of(field, *coordinate));
  const std::string of_angle = spelled(unit_of(field, {.name = {}, .speed = {}, .is_angle = true}));
  const std::string of_length = spelled(unit_of(field, {.name = {}, .speed = {}, .is_angle = false}));
  return of_angle == of_length ? of_angle : of_angle + " or " + of_length;
}

std::string with_default(const std::string& text, const std::string& value) {
  return text + "; " + value + " if not given";
}

Json field_schema(const Field& field, const void* defaults, const Coordinate* coordinate) {
  const std::string text = text_of(field.text, coordinate);
  const std::string unit = unit_for(field, coordinate);
  switch (field.type) {
    case Field::Type::number: {
      const double x = field.of<double>(defaults);
      const bool default_is_obvious = field.required || field.optional || x == 0;
      return number(unit, default_is_obvious ? text : with_default(text, text::number(x)), field.range);
    }
    case Field::Type::vector:
      return list(3, unit, text, field.range);
    case Field::Type::direction: {
      const Eigen::Vector3d& x = field.of<Direction>(defaults).along;
      return list(3, unit, with_default(text, numbers_of(x).dump()));
    }
    case Field::Type::numbers: {
      Json out = {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", field.min_count}};
      out["description"] = text + (unit.empty() ? "" : " [" + unit + "]");
      return out;
    }
    case Field::Type::flag:
      return {{"type", "boolean"}, {"description", text}};
    case Field::Type::choice: {
      const int i = field.of<Choice>(defaults).index;
      Json words = Json::array();
      for (const std::string_view word : field.words) words.push_back(word);
      const std::string default_word = i == Choice::none ? "" : std::string(field.words[static_cast<std::size_t>(i)]);
      return {{"enum", words}, {"description", default_word.empty() ? text : with_default(text, default_word)}};
    }
    case Field::Type::formula:
      return {{"type", {"string", "number"}}, {"description", text + (unit.empty() ? "" : " [" + unit + "]")}};
    case Field::Type::formulas:
      return {{"type", "array"},
              {"items", {{"type", {"string", "number"}}}},
              {"minItems", 3},
              {"maxItems", 3},
              {"description", text + (unit.empty() ? "" : " [" + unit + "]")}};
    case Field::Type::group:
      break;
  }
  return group(field, coordinate);
}

// Schema of a field along each coordinate: a number for one coordinate, a list for several.
Json per_coordinate(const Field& field, const JointKind& kind) {
  std::vector<std::string> names;
  std::vector<std::string> speeds;
  for (int i = 0; i < kind.nv; ++i) {
    if (kind.springs()) names.emplace_back(kind.q[i].name);
    speeds.emplace_back(kind.v[i].name);
  }
  const std::string all = text::list(names);
  const std::string all_speeds = text::list(speeds);
  const std::string text = sentence(filled_in(field.text, {}, {.name = all, .speed = all_speeds, .is_angle = true}));
  const std::string unit = common_unit(field, kind);
  return kind.nv == 1 ? number(unit, text, field.range) : list(kind.nv, unit, text, field.range);
}

}  // namespace

Json properties(std::span<const Field> fields, const void* defaults, const Coordinate* coordinate,
                std::vector<std::string>& required) {
  Json out = Json::object();
  for (const Field& field : fields) {
    const std::string name(field.name);
    out[name] = field_schema(field, defaults, coordinate);
    if (field.required) required.push_back(name);
  }
  return out;
}

void add_ways(Json& mapping, std::span<const Field> fields) {
  Json alternatives = Json::array();
  for (const std::vector<std::string>& alternative : alternatives_of(fields)) {
    Json any = Json::array();
    for (const std::string& name : alternative) any.push_back({{"required", Json::array({name})}});
    alternatives.push_back(any.size() == 1 ? any[0] : Json{{"anyOf", any}});
  }
  if (alternatives.size() == 1) mapping.update(alternatives[0]);
  if (alternatives.size() > 1) mapping["oneOf"] = alternatives;
}

Json group(const Field& field, const Coordinate* coordinate) {
  std::vector<std::string> required;
  Json out = object(properties(field.inner(), field.defaults(), coordinate, required), required);
  add_ways(out, field.inner());
  out["description"] = text_of(field.text, coordinate);
  return out;
}

Json along(const JointForceKind& force, const Coordinate& coordinate) {
  std::vector<std::string> required;
  Json out = object(properties(force.fields, force.defaults(), &coordinate, required), required);
  add_ways(out, force.fields);
  out["description"] = sentence(std::string(force.summary));
  return out;
}

Json joint_numbers(const JointKind& kind, std::vector<std::string>& required) {
  const Stored<AnyJoint> plain = make_joint(kind.name, default_axes(kind));
  Json out = properties(kind.fields, data_of(*plain), nullptr, required);
  for (const JointForceKind& force : joint_force_kinds()) {
    if (!force.fits(kind)) continue;
    if (!force.group.empty()) {
      Json& group = out[std::string(force.group)];
      if (force.of_joint) {
        group = along(force, coordinate_of(kind, 0));
        continue;
      }
      Json by_name = Json::object();
      for (int i = 0; i < kind.nv; ++i) {
        const Coordinate coordinate = coordinate_of(kind, i);
        by_name[std::string(coordinate.name)] = along(force, coordinate);
      }
      group = kind.nv == 1 ? by_name.front() : object(by_name, {});
      if (kind.nv > 1) group["minProperties"] = 1;
      if (kind.nv > 1) group["description"] = sentence(std::string(force.summary) + ", by the names of coordinates");
      continue;
    }
    for (const Field& field : force.fields) out[std::string(field.name)] = per_coordinate(field, kind);
  }
  for (const Field& field : kind.fields) {  // "friction.translation" is in the mapping of "friction"
    const std::size_t dot = field.name.find('.');
    if (dot == std::string_view::npos) continue;
    Json& group = out[std::string(field.name.substr(0, dot))];
    group["properties"][std::string(field.name.substr(dot + 1))] = std::move(out[std::string(field.name)]);
    out.erase(std::string(field.name));
  }
  return out;
}

namespace {

void add_port(const Port& port, Json& fields, std::vector<std::string>& required) {
  const std::string text(port.text);
  if (port.name.empty()) {
    fields["body"] = schema::string("Name of a body" + std::string(port.on_ground ? ", or ground" : ""));
    if (port.kind != Port::Kind::body) fields["position"] = list(3, "m", text);
    if (port.kind == Port::Kind::frame) fields["rotation"] = reference("rotation");
    required.emplace_back("body");
    return;
  }
  const std::string name(port.name);
  switch (port.kind) {
    case Port::Kind::frame:
      fields[name] = reference("frame");
      break;
    case Port::Kind::point:
      fields[name] = reference("point");
      break;
    case Port::Kind::body:
      fields[name] = schema::string("Name of a body: " + text);
      break;
    case Port::Kind::joint:
      fields[name] = schema::string("Name of a joint: " + text);
      if (port.has_coordinate)
        fields["coordinate"] = schema::string("Name of the coordinate, if the joint has several");
      break;
    case Port::Kind::surfaces:
      fields[name] = {{"type", "array"},
                      {"items", schema::string("Name of a surface")},
                      {"minItems", 2},
                      {"maxItems", 2},
                      {"description", text}};
  }
  if (!port.optional) required.push_back(name);
}

template <class Any>
Json elements(const Section& section) {
  Json cases = Json::array();
  Json names = Json::array();
  std::size_t n = 0;
  for (const ElementKind& kind : element_kinds<Any>()) {
    const Stored<Any> defaults = make_element<Any>(n++);
    const std::string name(kind.kind);
    Json fields;
    std::vector<std::string> required;
    fields["type"] = {{"const", name}, {"description", sentence(std::string(kind.summary))}};
    if (section.default_type != kind.kind) required.emplace_back("type");
    for (const Port& port : kind.ports) add_port(port, fields, required);
    fields.update(properties(kind.fields, data_of(*defaults), nullptr, required));
    if (section.name == components_section.name)
      fields["start"] = {{"type", "object"},
                         {"description", "Start values of its states, in SI units"},
                         {"additionalProperties", {{"type", "number"}}}};
    names.push_back(name);
    Json element = object(fields, required);
    add_ways(element, kind.fields);
    cases.push_back(when_type(name, element));
  }
  return by_type(names, cases, std::string(section.default_type));
}

// A mesh: the name of a file, this with a scale, or its points and triangles.
Json mesh() {
  const Json file = schema::string("File in the folder of the scene, such as .stl, .obj, .ply");
  Json scaled =
      object({{"file", file}, {"scale", number("m", "Length of the file's unit", Range::positive)}}, {"file"});
  Json corner = {{"type", "integer"}, {"minimum", 0}};
  Json triangle = {{"type", "array"}, {"items", std::move(corner)}, {"minItems", 3}, {"maxItems", 3}};
  Json points = {{"type", "array"}, {"items", list(3, "m", "A point")}, {"minItems", 4}};
  Json triangles = {{"type", "array"}, {"items", std::move(triangle)}, {"minItems", 4}};
  Json listed = object({{"points", std::move(points)}, {"triangles", std::move(triangles)}}, {"points", "triangles"});
  return {{"oneOf", {file, std::move(scaled), std::move(listed)}}};
}

}  // namespace

Json elements(const Section& section, const std::vector<Motor>&) { return elements<AnyMotor>(section); }
Json elements(const Section& section, const std::vector<Force>&) { return elements<AnyForce>(section); }
Json elements(const Section& section, const std::vector<Constraint>&) { return elements<AnyConstraint>(section); }
Json elements(const Section& section, const std::vector<Contact>&) { return elements<AnyContact>(section); }
Json elements(const Section& section, const std::vector<Sensor>&) { return elements<AnySensor>(section); }
Json elements(const Section& section, const std::vector<Component>&) { return elements<AnyComponent>(section); }

Json shapes() {
  Json fields = {
      {"position", list(3, "m", "Origin of its frame in the body")},
      {"rotation", reference("rotation")},
      {"surface", schema::string("Name of its surface, to which contacts refer; it touches nothing if not given")}};
  Json kinds = Json::array();
  for (std::size_t n = 0; n < shape_kinds().size(); ++n) {
    const ShapeKind& kind = shape_kinds()[n];
    const std::string name(kind.kind);
    std::vector<std::string> required;
    const Stored<AnyShape> plain = make_shape(n);
    Json own = properties(kind.fields, data_of(*plain), nullptr, required);
    if (kind.of_triangles) {
      own = mesh();
    } else if (kind.of_points) {
      own = {{"type", "array"}, {"items", list(3, "m", "A point")}, {"minItems", 4}};
    } else if (!kind.bounded) {
      own = list(3, "", "Outward normal of the surface");
    } else if (kind.fields.size() == 1) {
      own = Json(own.front());
    } else {
      own = object(own, required);
    }
    own["description"] = sentence(std::string(kind.summary)) +
                         (own.contains("description") ? ": " + own["description"].get<std::string>() : "");
    fields[name] = std::move(own);
    kinds.push_back({{"required", {name}}});
  }
  Json shape = object(fields, {});
  shape["oneOf"] = kinds;
  return schema::section(
      shape, "Shapes, which give the body its picture, its mass if a density is given, and its contacts.", false);
}

}  // namespace gelenk::schema
