// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include "bindings.h"
#include "scene/read.h"

namespace nb = nanobind;
using gelenk::Scene;

void gelenk::bind_scene(nb::module_& m) {
  nb::class_<Scene>(m, "Scene", "A scene that has been read and found valid. Immutable.")
      .def_ro("name", &Scene::name, "Name of the mechanism.")
      .def_ro("file", &Scene::file, "Where the scene came from; empty if not from a file.")
      .def_prop_ro(
          "stop", [](const Scene& s) { return s.experiment.stop; }, "Default end of a run [s].")
      .def_prop_ro(
          "step", [](const Scene& s) { return s.experiment.step; }, "Default communication step [s].")
      .def_prop_ro(
          "tolerance", [](const Scene& s) { return s.experiment.tolerance; }, "Default relative tolerance.")
      .def_prop_ro(
          "integrator", [](const Scene& s) { return s.solver.integrator; }, "Name of the integrator.")
      .def_prop_ro("formulation", [](const Scene& s) { return s.solver.formulation; }, "Name of the formulation.");

  m.def("read_scene_json", &gelenk::read_scene_json, nb::arg("text"), nb::arg("file"),
        "Read a scene from JSON text; file is only used in messages. Raises SceneError with every fault found.");
  m.def("write_scene_json", &gelenk::write_scene_json, nb::arg("scene"),
        "The scene as JSON text: all defaults filled in, all frames in bodies.");
  m.def("scene_schema", &gelenk::scene_schema, "JSON Schema (draft 2020-12) of scene files.");
}
