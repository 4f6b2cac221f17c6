// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/assemblies.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <tuple>
#include <utility>

#include "bindings.h"

namespace nb = nanobind;
using gelenk::Assembly;
using gelenk::AssemblyPart;

namespace {

// The values of all coordinates, in the same order.
std::vector<double> values(const Assembly& assembly) {
  std::vector<double> out;
  for (const std::vector<double>& q : assembly.q) out.insert(out.end(), q.begin(), q.end());
  return out;
}

// Each island with the names ("A.phi") and the units of its coordinates.
using Listed = std::tuple<AssemblyPart, std::vector<std::string>, std::vector<std::string>>;
std::vector<Listed> listed(const gelenk::Scene& scene, const std::vector<std::string>& bodies, int most_starts,
                           unsigned seed) {
  const nb::gil_scoped_release release;
  std::vector<Listed> out;
  for (AssemblyPart& part : gelenk::list_assemblies(scene, bodies, most_starts, seed)) {
    auto& [shown, names, units] =
        out.emplace_back(std::move(part), std::vector<std::string>(), std::vector<std::string>());
    for (const int j : shown.joints) {
      const gelenk::Joint& joint = scene.joints[j];
      for (const gelenk::Quantity& q : gelenk::find_joint_kind(joint.type)->q) {
        names.push_back(joint.name + "." + std::string(q.name));
        units.emplace_back(q.unit);
      }
    }
  }
  return out;
}

}  // namespace

void gelenk::bind_assemblies(nb::module_& m) {
  nb::class_<Assembly>(m, "Assembly", "An assembly of one island.")
      .def_prop_ro("values", &values, "Values of all coordinates of the island.")
      .def_ro("distance", &Assembly::distance)
      .def_ro("degrees_of_freedom", &Assembly::degrees_of_freedom)
      .def_ro("hits", &Assembly::hits)
      .def_ro("chosen", &Assembly::chosen)
      .def_ro("flat", &Assembly::flat);
  nb::class_<AssemblyPart>(m, "AssemblyPart", "An island with loops, and its assemblies.")
      .def_ro("assemblies", &AssemblyPart::assemblies)
      .def_ro("starts", &AssemblyPart::starts)
      .def_ro("closed", &AssemblyPart::closed)
      .def_ro("settled", &AssemblyPart::settled);
  m.def("list_assemblies", &listed, nb::arg("scene"), nb::arg("bodies"), nb::arg("most_starts"), nb::arg("seed"),
        "For each island with loops: its assemblies, names and units of its coordinates. Raises AssemblyError.");
}
