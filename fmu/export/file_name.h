// SPDX-License-Identifier: BSD-3-Clause
// File names derived from names in a scene, for files in the working directory and in the archive of an FMU.
#pragma once

#include <string>
#include <string_view>

namespace gelenk {

// Whether Windows reserves the name for a device: CON, NUL, COM1 etc., regardless of case and extension ("con.txt").
// Such files cannot be opened there, nor can archives with them be extracted. (Microsoft, "Naming Files, Paths, and
// Namespaces".)
bool is_device_name(std::string_view name);

// A file name without extension for the name (UTF-8): the name itself if it is valid on Linux, macOS and Windows, is
// not hidden and does not contain a path; otherwise a similar one, with _ in place of invalid characters.
std::string file_stem(std::string_view name);

// A modelIdentifier for the name: a C identifier, as FMI requires. The FMU's libraries have this name.
std::string model_identifier(std::string_view name);

}  // namespace gelenk
