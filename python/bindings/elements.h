// SPDX-License-Identifier: BSD-3-Clause
// Kinds of elements and their numbers, as Python sees them.
#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "element/element.h"

namespace gelenk {

// By the name of the field; those of a group as "sine.phase". A flag: 0 or 1, a choice: its place among the words.
using ElementNumbers = std::map<std::string, std::variant<double, std::vector<double>>>;

// By section of the scene: a list of kinds.
nanobind::dict shown_kinds();
// defaults: an element with what its fields hold at first.
nanobind::list shown_fields(std::span<const Field> fields, const void* defaults);
nanobind::list shown_signals(std::span<const SignalGroup> groups);
// Of what joints have, which has no name of its own: the mapping it stands in, or its first field.
std::string name_along(std::string_view group, std::span<const Field> fields);
// Throws std::invalid_argument for a name or a size that is not the element's.
void put_number(std::span<const Field> fields, void* element, const std::string& name,
                const ElementNumbers::mapped_type& value);

}  // namespace gelenk
