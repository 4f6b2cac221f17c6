// SPDX-License-Identifier: BSD-3-Clause
// Elements in scene files: their fields read, checked, written and described in the JSON Schema.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/element_numbers.h"
#include "scene/json_fields.h"

namespace gelenk {

// Into the element; what the file does not give keeps its default.
void read_fields(Fields& from, std::span<const Field> fields, void* element, const Coordinate& coordinate);
// One field's value.
void read_field(const Json& value, const std::string& path, Faults& faults, const Field& field, void* element,
                const Coordinate& coordinate);

// Faults for what is not finite or out of its field's range.
void check_fields(std::span<const Field> fields, const void* element, const std::string& path,
                  const Coordinate& coordinate, Faults& faults);
// These, else one for ways to give the numbers that are mixed or all missing, else the element's own.
void check_element(std::span<const Field> fields, const void* element, const std::string& path,
                   const Coordinate& coordinate, const std::function<std::optional<ElementFault>()>& own_fault,
                   Faults& faults);

// Into the mapping; what is not given is left out.
void write_fields(Json& to, std::span<const Field> fields, const void* element);

// Whether an optional field is given.
bool is_given(const Field& field, const void* element);
// The names of the fields of each way, by way from 1 on.
std::vector<std::vector<std::string>> ways_of(std::span<const Field> fields);

}  // namespace gelenk
