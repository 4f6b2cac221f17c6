// SPDX-License-Identifier: BSD-3-Clause
// The resource location of fmi2Instantiate, for which masters use various spellings.
#pragma once

#include <filesystem>
#include <string_view>

namespace gelenk {

// The directory denoted by file:/path, file:///path, file:////path, file://localhost/path, or a plain path. In URIs,
// not in plain paths, percent escapes are decoded, and /C:/ becomes C:/. Throws std::invalid_argument for another
// scheme or host and for an invalid escape.
std::filesystem::path directory_of_uri(std::string_view location);

}  // namespace gelenk
