// SPDX-License-Identifier: BSD-3-Clause
// Elements in scene files: their fields read, checked, written and described in the JSON Schema.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/element_numbers.h"
#include "scene_file/json_fields.h"

namespace gelenk {

// Into the element; what the file does not give keeps its default.
void read_fields(Fields& from, std::span<const Field> fields, void* element, const Coordinate& coordinate);
// One field's value.
void read_field(const Json& value, const std::string& path, Faults& faults, const Field& field, void* element,
                const Coordinate& coordinate);

// Into the mapping; what is not given is left out.
void write_fields(Json& to, std::span<const Field> fields, const void* element);

}  // namespace gelenk
