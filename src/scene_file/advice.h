// SPDX-License-Identifier: BSD-3-Clause
// Hints on how to correct typical mistakes: words of other programs, decimal commas, units in numbers. Each function
// returns a clause that begins with "; ", or an empty text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene_file/json_tree.h"

namespace gelenk::advice {

// Hint for an unknown field; known: names of the fields that are permitted there.
std::string on_field(std::string_view name, const std::vector<std::string>& known);
// Hint for a value that should be a number; unit: expected unit of that number.
std::string on_number(const Json& found, std::string_view unit);
// Hint for a value that should be a list of `size` numbers; unit: that of the numbers.
std::string on_list(const Json& found, std::size_t size, std::string_view unit = {});
// Hint for a value that should be a mapping.
std::string on_mapping(const Json& found);
// Hint for a value that should be a section.
std::string on_section(const Json& found);
// Hint for a value that should be an inertia.
std::string on_inertia(const Json& found);

}  // namespace gelenk::advice
