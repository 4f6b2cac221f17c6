// SPDX-License-Identifier: BSD-3-Clause
// Reading and writing the fields of elements in scene files.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/element_numbers.h"
#include "scene_file/json_fields.h"

namespace gelenk {

// Reads the fields of an element; fields that the file does not give keep their defaults.
// names: what expressions may name besides their variables.
void read_fields(Fields& from, std::span<const Field> fields, void* element, const Coordinate& coordinate,
                 const FormulaNames& names = {});
// Reads the value of one field.
void read_field(const Json& value, const std::string& path, Faults& faults, const Field& field, void* element,
                const Coordinate& coordinate, const FormulaNames& names = {});

// Writes the fields of an element to a mapping, without optional ones that are not given.
void write_fields(Json& to, std::span<const Field> fields, const void* element);

}  // namespace gelenk
