// SPDX-License-Identifier: BSD-3-Clause
// The GUID of an FMU, by which it is checked that modelDescription.xml, scene.json and the runtime belong together.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace gelenk {

// Version of the exporter and of the runtime: both are built together.
std::string_view gelenk_version();

// FNV-1a, 128 bit, of the version and the scene file's bytes, as 8-4-4-4-12 hexadecimal digits.
std::string fingerprint(std::string_view scene_json);

// FNV-1a, 64 bit, to detect damaged data.
std::uint64_t checksum(std::string_view bytes);

}  // namespace gelenk
