// SPDX-License-Identifier: BSD-3-Clause
// What to do about a mistake that others have made before: words of other programs, decimal commas, units in numbers.
// Each sentence begins with "; ", or is empty.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene_file/json_tree.h"

namespace gelenk::advice {

// A field that is none of the known.
std::string on_field(std::string_view name, const std::vector<std::string>& known);
// Something else where a number is expected; unit: of that number.
std::string on_number(const Json& found, std::string_view unit);
// Something else where a list of so many numbers is expected.
std::string on_list(const Json& found, std::size_t size);
// Something else where a mapping is expected.
std::string on_mapping(const Json& found);
// Something else where a section is expected.
std::string on_section(const Json& found);
// Something else where an inertia is expected.
std::string on_inertia(const Json& found);

}  // namespace gelenk::advice
