// SPDX-License-Identifier: BSD-3-Clause
// Information about a scene that FMUs pass on to programs and their users.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gelenk {

// Each is an attribute of fmiModelDescription in FMI 2.0; empty: not given.
struct Metadata {
  std::string author, version, description, copyright, license;
};

// The name of a text, in scene files as in modelDescription.xml.
struct MetadataKey {
  std::string_view name;
  std::string Metadata::* text;
  std::string_view meaning;
};
inline constexpr MetadataKey metadata_keys[] = {
    {"author", &Metadata::author, "Author of the scene"},
    {"version", &Metadata::version, "Version of the scene, such as \"1.2.0\""},
    {"description", &Metadata::description, "What the scene describes"},
    {"copyright", &Metadata::copyright, "Copyright notice of the scene, such as \"2026 Example Ltd.\""},
    {"license", &Metadata::license, "License of the scene, such as \"BSD-3-Clause\""},
};
inline constexpr std::size_t max_metadata_size = 10'000;  // characters of one text

}  // namespace gelenk
