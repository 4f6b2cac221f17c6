// SPDX-License-Identifier: BSD-3-Clause
// Building blocks of the JSON Schema. Units are appended to descriptions in brackets.
#pragma once

#include <string>

#include "scene/scene.h"
#include "scene_file/json_fields.h"

namespace gelenk::schema {

Json number(const std::string& unit, const std::string& description, Range allowed = Range::any);
Json list(int size, const std::string& unit, const std::string& description, Range allowed = Range::any);
Json string(const std::string& description);
Json reference(const std::string& definition);

// Schema of a mapping with these fields and no others.
Json object(const Json& fields, const std::vector<std::string>& required);

// Schema of a mapping from names to entries; filled: it must have at least one.
Json section(const Json& entry, const std::string& description, bool filled);

// Schema of entries distinguished by their `type`; default_type: type of entries that name none, empty if required.
Json when_type(const std::string& type, const Json& then);
Json by_type(const Json& names, const Json& cases, const std::string& default_type = {});

// The rest is generated from the registry of elements (schema_elements.cpp). coordinate: the coordinate on which an
// element acts; nullptr if it is not known.

// Schemas of these fields by name; the names of required ones are appended to `required`.
Json properties(std::span<const Field> fields, const void* defaults, const Coordinate* coordinate,
                std::vector<std::string>& required);
Json group(const Field& field, const Coordinate* coordinate);
// Adds to a mapping which of its fields exclude each other.
void add_ways(Json& mapping, std::span<const Field> fields);
// Schemas of the fields of a joint: its own, and those of the forces along its coordinates.
Json joint_numbers(const JointKind& kind, std::vector<std::string>& required);
// Schema of an entry of a section; the second argument selects the kinds of elements.
Json elements(const Section& section, const std::vector<Motor>&);
Json elements(const Section& section, const std::vector<Force>&);
Json elements(const Section& section, const std::vector<Constraint>&);
Json elements(const Section& section, const std::vector<Contact>&);
Json elements(const Section& section, const std::vector<Sensor>&);
Json elements(const Section& section, const std::vector<Component>&);
// Schema of a mapping from names to shapes.
Json shapes();

}  // namespace gelenk::schema
