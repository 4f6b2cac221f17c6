// SPDX-License-Identifier: BSD-3-Clause
// Building blocks of the JSON Schema.
#pragma once

#include <string>

#include "scene/scene.h"
#include "scene_file/json_fields.h"

namespace gelenk::schema {

Json number(const std::string& unit, const std::string& description, Range allowed = Range::any);
Json list(int size, const std::string& unit, const std::string& description, Range allowed = Range::any);
Json string(const std::string& description);
Json reference(const std::string& definition);

// A mapping with these fields and no others.
Json object(const Json& fields, const std::vector<std::string>& required);

// A mapping from names to entries.
Json section(const Json& entry, const std::string& description, bool filled);

// Entries told apart by their `type`; usual: that of those which name none, if they may.
Json when_type(const std::string& type, const Json& then);
Json by_type(const Json& names, const Json& cases, const std::string& usual = {});

// What elements say of themselves (schema_elements.cpp). coordinate: what they act on; null: it is not known.
// Properties with these fields; required: names are added.
Json properties(std::span<const Field> fields, const void* defaults, const Coordinate* coordinate,
                std::vector<std::string>& required);
Json group(const Field& field, const Coordinate* coordinate);
// Which fields of a mapping exclude each other.
void add_ways(Json& mapping, std::span<const Field> fields);
// Properties of a joint: its own numbers, and what it can have along its coordinates.
Json joint_numbers(const JointKind& kind, std::vector<std::string>& required);
// An entry of a section of such elements.
Json elements(const Section& section, const std::vector<Motor>&);
Json elements(const Section& section, const std::vector<Force>&);
Json elements(const Section& section, const std::vector<Constraint>&);
Json elements(const Section& section, const std::vector<Sensor>&);

}  // namespace gelenk::schema
