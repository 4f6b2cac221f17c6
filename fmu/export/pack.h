// SPDX-License-Identifier: BSD-3-Clause
// Exporting: scene + prebuilt runtime -> FMU. Runs no compiler.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/export/zip.h"
#include "scene/scene.h"

namespace gelenk {

// A file that could not be read or written, and why.
class ExportError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Writes the FMU to `out`, as a whole or not at all; the same arguments give the same bytes.
//   runtimes  libraries with the FMI functions, whose endings tell the platform: .so linux64, .dll win64. They are
//             nearly all of an FMU, so they may come compressed once for all: .so.gz, .dll.gz are taken over
//   licenses  directory whose files go into documentation/licenses, and those of its directory named as a platform of
//             the FMU's; empty: none
//   compress  for all the rest; empty: it is stored as it is, and there is no model.png, which would be as large again
// Throws ExportError, SceneError, and AssemblyError when the start values cannot be assembled.
void export_fmu(const Scene& scene, const std::vector<std::filesystem::path>& runtimes,
                const std::filesystem::path& out, const std::filesystem::path& licenses, const Compress& compress);

}  // namespace gelenk
