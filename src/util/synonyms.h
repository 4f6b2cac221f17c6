// SPDX-License-Identifier: BSD-3-Clause
// Words of other programs and formats for the keys of scene files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

// Words separated by single spaces.
using Words = std::string_view;
// Whether the word is one of them; case is ignored.
bool contains(Words words, std::string_view word);

// Returns the word of scene files for which `found` is a synonym, if it is one of `known`; otherwise an empty string.
std::string canonical_name(std::string_view found, const std::vector<std::string>& known);

}  // namespace gelenk
