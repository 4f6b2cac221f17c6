// SPDX-License-Identifier: BSD-3-Clause
// fmi2Instantiate's resource location: masters write it in many ways.
#pragma once

#include <filesystem>
#include <string_view>

namespace gelenk {

// The directory meant by file:/path, file:///path, file:////path, file://localhost/path, or a plain path; percent
// escapes are resolved in URIs (not in plain paths), and C:/ is told from a leading /C:/.
// Throws std::invalid_argument for another scheme or host, and for a broken escape.
std::filesystem::path directory_of_uri(std::string_view location);

}  // namespace gelenk
