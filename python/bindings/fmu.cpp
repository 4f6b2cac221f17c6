// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "modelDescription/pack.h"

namespace nb = nanobind;

void gelenk::bind_fmu(nb::module_& m) {
  m.def(
      "export_fmu", &gelenk::export_fmu, nb::arg("scene"), nb::arg("runtimes"), nb::arg("out"), nb::arg("licenses"),
      nb::call_guard<nb::gil_scoped_release>(),
      "Write the FMU: scene, runtime libraries and the files of the folder licenses. Raises ExportError, SceneError,\n"
      "AssemblyError.");
}
