// SPDX-License-Identifier: BSD-3-Clause
// The tree of values of a scene file, before it is interpreted.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "scene/faults.h"

namespace gelenk {

// Keys keep the order of the file. Numbers may be NaN or infinite; readers of the tree report these with their path.
using Json = nlohmann::ordered_json;

// Limit of the nesting depth; scenes have at most seven levels (bodies.x.pose.rotation.matrix[1][2]).
inline constexpr std::size_t max_nesting = 32;

// Parses JSON. Throws SceneError "file:line:column: ..." for a syntax error. A key that occurs twice in a mapping adds
// an error to `faults`, and its first value is kept.
Json parse_json(std::string_view text, const std::string& file, Faults& faults);

}  // namespace gelenk
