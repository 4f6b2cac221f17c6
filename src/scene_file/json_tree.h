// SPDX-License-Identifier: BSD-3-Clause
// The tree of a scene file before it is understood.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "scene/faults.h"

namespace gelenk {

// Keys stay in the order of the file. A number may be NaN or infinite: who reads it says so, with its path.
using Json = nlohmann::ordered_json;

// Deeper than any scene goes (bodies.x.pose.rotation.matrix[1][2] has seven levels).
inline constexpr std::size_t deepest_level = 32;

// Reads JSON. A mistake of syntax is told as "file:line:column: ..." and ends the reading (SceneError); a
// key that a mapping has twice is a fault, and its first value stays.
Json parse_json(std::string_view text, const std::string& file, Faults& faults);

}  // namespace gelenk
