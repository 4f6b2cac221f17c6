// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <tuple>

#include "bindings.h"
#include "scene/doubts.h"
#include "scene/natural_time.h"
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
          "scales",
          [](const Scene& s) {
            const gelenk::UnitSystem units = gelenk::natural_units(s);
            return std::array{units.length, units.mass, gelenk::natural_time(s, units)};
          },
          "A length [m], a mass [kg] and a time [s] near its own: powers of two, 1 where these are usual.")
      .def_prop_ro(
          "step", [](const Scene& s) { return s.experiment.step; }, "Default communication step [s].")
      .def_prop_ro(
          "tolerance", [](const Scene& s) { return s.experiment.tolerance; }, "Default relative tolerance.")
      .def_prop_ro(
          "integrator", [](const Scene& s) { return s.solver.integrator; }, "Name of the integrator.")
      .def_prop_ro("formulation", [](const Scene& s) { return s.solver.formulation; }, "Name of the formulation.");

  m.def("check_size", &gelenk::check_size, nb::arg("size"), nb::arg("file"),
        "Raises SceneError where a scene file of so many bytes is too large to be read.");
  m.def(
      "read_scene_json",
      [](std::string_view text, const std::string& file) { return gelenk::read_scene_json(text, file); },
      nb::arg("text"), nb::arg("file"),
      "Read a scene from JSON text; file is only used in messages. Raises SceneError with every fault found.");
  m.def(
      "read_scene_and_doubts",
      [](std::string_view text, const std::string& file) {
        std::vector<std::string> doubts;
        Scene scene = gelenk::read_scene_json(text, file, doubts);
        return std::tuple(std::move(scene), std::move(doubts));
      },
      nb::arg("text"), nb::arg("file"), "Likewise, and what in it is allowed and hardly meant, one line each.");
  m.def(
      "find_doubts", [](const Scene& scene) { return gelenk::find_doubts(scene); }, nb::arg("scene"),
      "What in a scene is allowed and hardly meant, one line each.");
  m.def("write_scene_json", &gelenk::write_scene_json, nb::arg("scene"),
        "The scene as JSON text: all defaults filled in, all frames in bodies.");
  m.def("scene_schema", &gelenk::scene_schema, "JSON Schema (draft 2020-12) of scene files.");
}
