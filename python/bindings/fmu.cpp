// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bindings.h"
#include "fmu/export/file_name.h"
#include "fmu/export/pack.h"
#include "fmu/export/picture.h"
#include "simulation/simulation.h"

namespace nb = nanobind;

namespace {

using PlatformAndFile = std::pair<std::string, std::filesystem::path>;
using PyCompress = nb::typed<nb::callable, nb::bytes(nb::bytes)>;
using PyWriteView = nb::typed<nb::callable, std::string(std::string, nb::typed<nb::list, double>)>;

// version: 2 or 3. compress: zlib.compress, or None. view: as WriteView, or None.
void export_packed(const gelenk::Scene& scene, const std::vector<PlatformAndFile>& runtimes,
                   const std::filesystem::path& out, const std::filesystem::path& licenses,
                   const std::optional<PyCompress>& compress, const std::optional<PyWriteView>& view, int version) {
  gelenk::Compress call;
  if (compress) {
    call = [&compress](std::string_view bytes) {
      const nb::gil_scoped_acquire held;
      const auto stream = nb::cast<nb::bytes>((*compress)(nb::bytes(bytes.data(), bytes.size())));
      return std::string(stream.c_str(), stream.size());
    };
  }
  gelenk::WriteView draw;
  if (view) {
    draw = [&view](const std::string& json, const std::vector<double>& poses) {
      const nb::gil_scoped_acquire held;
      return nb::cast<std::string>((*view)(json, poses));
    };
  }
  std::vector<gelenk::Runtime> libraries;
  for (const auto& [platform, file] : runtimes) libraries.push_back({platform, file});
  const nb::gil_scoped_release released;
  gelenk::export_fmu(scene, libraries, out, licenses, static_cast<gelenk::FmiVersion>(version), call, draw);
}

std::string svg_of(const gelenk::Scene& scene) {
  const nb::gil_scoped_release released;
  gelenk::Simulation simulation(scene);
  simulation.assemble();
  return gelenk::write_svg(gelenk::draw(simulation));
}

}  // namespace

void gelenk::bind_fmu(nb::module_& m) {
  m.def("export_fmu", &export_packed, nb::arg("scene"), nb::arg("runtimes"), nb::arg("out"), nb::arg("licenses"),
        nb::arg("compress").none(), nb::arg("view").none() = nb::none(), nb::arg("version") = 2,
        "Write the FMU of FMI 2.0 or 3.0 (version: 2, 3) with the scene, the runtime libraries (platform and file)\n"
        "and the files of the folder licenses, compressed by compress (zlib.compress, or None). view returns "
        "documentation/view.html for the scene as JSON\n"
        "and the poses of its bodies (position and quaternion x, y, z, w, in one list); None: there is no such page.\n"
        "Raises ExportError, SceneError, AssemblyError, and what view raises.");
  m.def("draw_svg", &svg_of, nb::arg("scene"),
        "A drawing of the scene at its start, as an SVG element. Raises SceneError, AssemblyError.");
  m.def("file_stem", &gelenk::file_stem, nb::arg("name"),
        "The name, or a similar one that is a valid file name on Linux, macOS and Windows.");
  m.def("is_device_name", &gelenk::is_device_name, nb::arg("name"), "Whether Windows reserves the name for a device.");
}
