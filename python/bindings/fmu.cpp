// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "modelDescription/file_name.h"
#include "modelDescription/pack.h"

namespace nb = nanobind;

void gelenk::bind_fmu(nb::module_& m) {
  m.def(
      "export_fmu", &gelenk::export_fmu, nb::arg("scene"), nb::arg("runtimes"), nb::arg("out"), nb::arg("licenses"),
      nb::call_guard<nb::gil_scoped_release>(),
      "Write the FMU: scene, runtime libraries and the files of the folder licenses. Raises ExportError, SceneError,\n"
      "AssemblyError.");
  m.def("file_stem", &gelenk::file_stem, nb::arg("name"),
        "The name, or the nearest one that is a file's on Linux, macOS and Windows.");
  m.def("is_device_name", &gelenk::is_device_name, nb::arg("name"), "Whether Windows keeps the name for a device.");
}
