// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/parameters.h"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "bindings.h"
#include "scene/settable.h"
#include "scene_file/read.h"
#include "simulation/simulation.h"

namespace nb = nanobind;
using gelenk::Parameter;
using gelenk::Scene;

namespace {

using Setting = std::pair<std::string, double>;

const char* parameter_type(const Parameter& p) {
  switch (p.type) {
    case gelenk::ParameterType::boolean:
      return "boolean";
    case gelenk::ParameterType::enumeration:
      return "enumeration";
    case gelenk::ParameterType::integer:
      return "integer";
    default:
      return "real";
  }
}

// Applies all settings before the check, since some conditions involve several values (moments of inertia).
Scene with_parameters(const Scene& scene, const std::vector<Setting>& settings) {
  Scene changed = scene;
  const auto table = gelenk::scene_parameters(scene);
  for (const auto& [name, value] : settings) {
    const auto found = std::ranges::find(table, name, &Parameter::name);
    if (found == table.end()) throw gelenk::UsageError(name + ": no such parameter");
    try {
      gelenk::set_parameter(changed, *found, value);
    } catch (const std::invalid_argument& e) {
      throw gelenk::UsageError(e.what());
    }
  }
  return gelenk::checked(changed);
}

// Paths, and the size of the array of numbers at each.
std::vector<std::pair<std::string, int>> settable_paths(const Scene& scene) {
  std::vector<std::pair<std::string, int>> out;
  for (const gelenk::Settable& settable : gelenk::settables(scene)) out.emplace_back(settable.path, settable.size);
  return out;
}

}  // namespace

void gelenk::bind_parameters(nb::module_& m) {
  nb::class_<Parameter>(m, "Parameter", "A number of a scene that can be set before a run starts.")
      .def_ro("name", &Parameter::name)
      .def_ro("unit", &Parameter::unit)
      .def_ro("description", &Parameter::description)
      .def_prop_ro("type", &parameter_type,
                   "real, integer, boolean (0 or 1) or enumeration (number of the item, from 1).")
      .def_ro("items", &Parameter::items, "Names of the items of an enumeration.")
      .def_ro("min", &Parameter::min)
      .def_ro("max", &Parameter::max)
      .def_ro("tunable", &Parameter::tunable, "Whether it may change during a run.")
      .def_ro("keeps_positions", &Parameter::keeps_positions,
              "Whether it is a number of a body, or a tunable one of a joint, motor or force.")
      .def("value", [](const Parameter& p, const Scene& scene) { return p.get(scene); }, nb::arg("scene"));
  m.def("list_parameters", &gelenk::scene_parameters, nb::arg("scene"), "All parameters of the scene.");
  m.def("list_settables", &settable_paths, nb::arg("scene"),
        "What a scene can list under `parameters`: (path in the file, size), gravity first.");
  m.def("with_parameters", &with_parameters, nb::arg("scene"), nb::arg("settings"),
        "A copy of the scene with these (name, value) settings. Raises UsageError, SceneError.");
}
