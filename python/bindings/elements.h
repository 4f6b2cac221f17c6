// SPDX-License-Identifier: BSD-3-Clause
// Conversion of kinds of elements and of their numbers for Python.
#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "element/element.h"

namespace gelenk {

// Values by name of the field, in groups as "sine.phase". Flags are 0 or 1, choices the index of the word.
using ElementNumbers =
    std::map<std::string, std::variant<double, std::vector<double>, std::string, std::vector<std::string>>>;

// For each section of the scene, a list of its kinds.
nanobind::dict shown_kinds();
// defaults: an element with the default values of its fields.
nanobind::list shown_fields(std::span<const Field> fields, const void* defaults);
nanobind::list shown_signals(std::span<const SignalGroup> groups);
// The name of a force along a joint coordinate: its mapping in the joint, or its first field.
std::string name_along(std::string_view group, std::span<const Field> fields);
// Throws std::invalid_argument for an unknown name or a wrong size.
void put_number(std::span<const Field> fields, void* element, const std::string& name,
                const ElementNumbers::mapped_type& value);

}  // namespace gelenk
