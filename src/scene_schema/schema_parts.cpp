// SPDX-License-Identifier: BSD-3-Clause
#include "scene_schema/schema_parts.h"

namespace gelenk::schema {

Json number(const std::string& unit, const std::string& description, Range allowed) {
  Json out;
  out["type"] = "number";
  if (allowed == Range::not_negative || allowed == Range::fraction) out["minimum"] = 0;
  if (allowed == Range::fraction || allowed == Range::at_most_one) out["maximum"] = 1;
  if (allowed == Range::positive) out["exclusiveMinimum"] = 0;
  if (allowed == Range::not_zero) out["not"] = {{"const", 0}};
  out["description"] = unit.empty() ? description : description + " [" + unit + "]";
  return out;
}

Json list(int size, const std::string& unit, const std::string& description, Range allowed) {
  Json out = {{"type", "array"}, {"items", number(unit, description, allowed)}};
  out["items"].erase("description");
  out["minItems"] = size;
  out["maxItems"] = size;
  out["description"] = unit.empty() ? description : description + " [" + unit + "]";
  return out;
}

Json string(const std::string& description) { return {{"type", "string"}, {"description", description}}; }

Json reference(const std::string& definition) { return {{"$ref", "#/$defs/" + definition}}; }

Json object(const Json& fields, const std::vector<std::string>& required) {
  Json out;
  out["type"] = "object";
  out["properties"] = fields;
  if (!required.empty()) out["required"] = required;
  out["additionalProperties"] = false;
  return out;
}

Json section(const Json& entry, const std::string& description, bool filled) {
  Json out;
  out["description"] = description;
  out["type"] = "object";
  out["propertyNames"] = {{"pattern", "^[A-Za-z_][A-Za-z0-9_]*$"}, {"maxLength", 200}, {"not", {{"const", "ground"}}}};
  out["additionalProperties"] = entry;
  if (filled) out["minProperties"] = 1;
  return out;
}

Json when_type(const std::string& type, const Json& then) {
  return {{"if", {{"properties", {{"type", {{"const", type}}}}}}}, {"then", then}};
}

Json by_type(const Json& names, const Json& cases, const std::string& default_type) {
  Json out;
  out["type"] = "object";
  out["properties"]["type"]["enum"] = names;
  if (!default_type.empty()) out["properties"]["type"]["default"] = default_type;
  if (default_type.empty()) out["required"] = {"type"};
  out["allOf"] = cases;
  return out;
}

}  // namespace gelenk::schema
