// SPDX-License-Identifier: BSD-3-Clause
// Names that come from a scene and become files: in the folder where one stands, in an FMU's archive.
#pragma once

#include <string>
#include <string_view>

namespace gelenk {

// CON, NUL, COM1 and the like, in small letters too, also with an ending ("con.txt"): Windows opens a device instead of
// such a file, and archives that hold one cannot be unpacked there. (Microsoft, "Naming Files, Paths, and Namespaces".)
bool is_device_name(std::string_view name);

// What is to stand before a file's ending: the name itself where it is a file name on Linux, macOS and Windows, that of
// a file in the folder itself and not hidden; else the nearest one, with _ for what cannot be. name: UTF-8.
std::string file_stem(std::string_view name);

// What FMI wants a modelIdentifier to be, a name of C, which names the FMU's libraries.
std::string model_identifier(std::string_view name);

}  // namespace gelenk
