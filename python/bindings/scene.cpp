// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

#include "bindings.h"
#include "check/warnings.h"
#include "element/locking.h"
#include "joint/kinds.h"
#include "mechanism/wanted_part.h"
#include "scene/natural_time.h"
#include "scene/signals.h"
#include "scene/wanted_outputs.h"
#include "scene_file/read.h"
#include "scene_schema/schema.h"

namespace nb = nanobind;
using gelenk::Scene;

namespace {

// Names of the outputs that are the components of a quaternion, and of those that are its angular velocity.
using Quaternion = std::tuple<std::string, std::vector<std::string>, std::vector<std::string>>;
std::vector<Quaternion> quaternions(const Scene& scene) {
  std::vector<Quaternion> out;
  for (const gelenk::Joint& joint : scene.joints) {
    const gelenk::JointKind& kind = *gelenk::find_joint_kind(joint.type);
    if (!kind.has_quaternion()) continue;
    const auto names = [&](std::span<const gelenk::Quantity> of) {
      std::vector<std::string> named;
      for (const gelenk::Quantity& q : of) named.push_back(joint.name + "." + std::string(q.name));
      return named;
    };
    out.emplace_back(joint.name, names(kind.q.last(4)), names(kind.v.last(3)));
  }
  return out;
}

std::vector<std::string> names_of(const std::vector<gelenk::Signal>& signals) {
  std::vector<std::string> out;
  for (const gelenk::Signal& signal : signals) out.push_back(signal.name);
  return out;
}

void bind_outputs(nb::module_& m) {
  m.def(
      "with_outputs",
      [](Scene scene, const std::vector<std::string>& outputs) {
        scene.outputs = outputs;
        scene.is_wanted_part = false;
        return scene;
      },
      nb::arg("scene"), nb::arg("outputs"),
      "A copy that requests these outputs (all if empty), which faults_of_outputs must have accepted.");
  m.def("faults_of_outputs", &gelenk::faults_of_outputs, nb::arg("scene"), nb::arg("outputs"),
        "Errors in these names and patterns, a clause each.");
  m.def("diagnostic_names", [] { return names_of(gelenk::diagnostic_signals()); }, "The names of all diagnostics.");
  m.def(
      "input_names", [](const Scene& scene) { return names_of(gelenk::input_signals(scene)); }, nb::arg("scene"),
      "The names of all inputs of the scene.");
  m.def("output_signals", &gelenk::output_signals, nb::arg("scene"), "All outputs of the scene, requested or not.");
  m.def("quaternions", &quaternions, nb::arg("scene"),
        "Of each joint with a quaternion: its name, the names of the components, and of its angular velocity.");
  m.def("meets", &gelenk::output_matches, nb::arg("pattern"), nb::arg("name"),
        "Whether a name is equal to, or matches, the pattern.");
  m.def(
      "wanted_part", [](const Scene& scene) { return gelenk::wanted_part(scene).scene; }, nb::arg("scene"),
      "The scene without the parts that none of its requested outputs depends on.");
}

void bind_friction(nb::module_& m) {
  m.def(
      "without_friction",
      [](Scene scene) {
        for (gelenk::Joint& joint : scene.joints) {
          for (gelenk::Stored<gelenk::JointForces>& forces : joint.along) gelenk::erase_friction(*forces);
        }
        return scene;
      },
      nb::arg("scene"), "The scene without dry friction.");
  m.def(
      "has_friction_or_limits",
      [](const Scene& scene) {
        return std::ranges::any_of(scene.joints,
                                   [](const gelenk::Joint& joint) { return !joint.locking_element().empty(); });
      },
      nb::arg("scene"), "Whether any of its joints has dry friction or a hard limit.");
}

}  // namespace

void gelenk::bind_scene(nb::module_& m) {
  nb::class_<Scene>(m, "Scene", "A scene that has been read and found valid. Immutable.")
      .def_ro("name", &Scene::name, "Name of the mechanism.")
      .def_ro("file", &Scene::file, "The scene's file; empty if it was not read from a file.")
      .def_prop_ro(
          "stop", [](const Scene& s) { return s.experiment.stop; }, "Default end of a run [s].")
      .def_prop_ro(
          "scales",
          [](const Scene& s) {
            const gelenk::UnitSystem units = gelenk::natural_units(s);
            return std::array{units.length, units.mass, gelenk::natural_time(s, units)};
          },
          "A length [m], mass [kg] and time [s] typical of the mechanism: powers of two, 1 in ordinary scenes.")
      .def_prop_ro(
          "step", [](const Scene& s) { return s.experiment.step; }, "Default communication step [s].")
      .def_prop_ro(
          "tolerance", [](const Scene& s) { return s.experiment.tolerance; }, "Default relative tolerance.")
      .def_prop_ro(
          "integrator", [](const Scene& s) { return s.solver.integrator; }, "Name of the integrator.")
      .def_ro("outputs", &Scene::outputs, "Names and patterns of the requested outputs; empty: all.")
      .def_ro("is_wanted_part", &Scene::is_wanted_part,
              "Whether parts that no requested output depends on have already been removed.")
      .def_prop_ro(
          "formulation", [](const Scene& s) { return s.solver.formulation; }, "Name of the formulation.")
      .def("__getstate__",
           [](const Scene& s) { return std::tuple(gelenk::write_scene_json(s), s.file, s.is_wanted_part); })
      .def("__setstate__", [](Scene& s, const std::tuple<std::string, std::string, bool>& state) {
        new (&s) Scene(gelenk::read_scene_json(std::get<0>(state), std::get<1>(state)));
        s.is_wanted_part = std::get<2>(state);
      });

  bind_friction(m);
  m.def("check_size", &gelenk::check_size, nb::arg("size"), nb::arg("file"),
        "Raise SceneError if a scene file of this size [bytes] is too large to be read.");
  m.def(
      "read_scene_json",
      [](std::string_view text, const std::string& file) { return gelenk::read_scene_json(text, file); },
      nb::arg("text"), nb::arg("file"),
      "Read a scene from JSON text; file is only used in messages. Raises SceneError with all errors found.");
  m.def(
      "read_scene_and_doubts",
      [](std::string_view text, const std::string& file) {
        std::vector<std::string> doubts;
        Scene scene = gelenk::read_scene_json(text, file, doubts);
        return std::tuple(std::move(scene), std::move(doubts));
      },
      nb::arg("text"), nb::arg("file"),
      "Read a scene from JSON text; also return warnings about entries that are valid but suspicious, one line each.");
  m.def(
      "find_doubts", [](const Scene& scene) { return gelenk::find_warnings(scene); }, nb::arg("scene"),
      "Warnings about entries of a scene that are valid but suspicious, one line each.");
  bind_outputs(m);
  m.def("write_scene_json", &gelenk::write_scene_json, nb::arg("scene"),
        "The scene as JSON text, with all defaults filled in and all frames given in bodies.");
  m.def("scene_schema", &gelenk::scene_schema, "JSON Schema (draft 2020-12) of scene files.");
}
