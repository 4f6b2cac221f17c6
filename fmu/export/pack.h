// SPDX-License-Identifier: BSD-3-Clause
// Export: scene + prebuilt runtime -> FMU, without a compiler.
#pragma once

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/export/zip.h"
#include "modelDescription/write_xml.h"
#include "scene/scene.h"

namespace gelenk {

// A file could not be read or written; the message gives the reason.
class ExportError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Returns a page that shows the mechanism at its start in three dimensions, for documentation/view.html; empty: none.
//   scene  as written to resources/scene.json
//   poses  X_WB of each body of that scene: position [m] and quaternion (x, y, z, w)
using WriteView = std::function<std::string(const std::string& scene, const std::vector<double>& poses)>;

// A library with the FMI functions.
struct Runtime {
  std::string platform;        // linux64, aarch64-linux, win64 or darwin64, as FMI 2.0 calls them
  std::filesystem::path file;  // .so, .dll or .dylib; with .gz if it is compressed
};

// Writes the FMU to `out`, completely or not at all, as write_file() does. The same arguments give the same bytes.
//   runtimes  since they are nearly all of an FMU, precompressed files are accepted and not compressed again. The files
//             in the folder `licenses` beside a runtime are copied to documentation/licenses
//   licenses  directory whose files are copied there for all platforms; empty: none
//   compress  used for all other files; empty: they are stored uncompressed, and model.png is omitted because of its
//   size
//   version   of FMI
//   view      writes the page with the view in three dimensions; empty: the documentation has only a drawing
// Throws ExportError, SceneError, and AssemblyError if the loops cannot be closed from the start values.
void export_fmu(const Scene& scene, const std::vector<Runtime>& runtimes, const std::filesystem::path& out,
                const std::filesystem::path& licenses, FmiVersion version, const Compress& compress,
                const WriteView& view);

}  // namespace gelenk
