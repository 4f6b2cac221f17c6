// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/string.h>

#include <string>

#include "bindings.h"
#include "simulation/simulation.h"

namespace nb = nanobind;
using gelenk::ModelSize;
using gelenk::Signal;

namespace {

void bind_signal(nb::module_& m) {
  nb::class_<Signal>(m, "Signal", "Name, unit and description of an input, output or diagnostic.")
      .def_ro("name", &Signal::name)
      .def_ro("unit", &Signal::unit)
      .def_ro("description", &Signal::description)
      .def_ro("joint", &Signal::joint, "Index of the joint in the file; -1: not a joint variable.")
      .def_ro("level", &Signal::level, "0 coordinate, 1 velocity, 2 acceleration; -1: not a joint variable.")
      .def_ro("component", &Signal::component, "Index within the joint's coordinates, velocities or accelerations.")
      .def_ro("derivative", &Signal::derivative, "Index of the output that is its time derivative; -1: none.")
      .def("__repr__", [](const Signal& s) { return "<Signal " + s.name + " [" + s.unit + "]>"; });
}

// Deprecated names of sizes, which warn.
template <int ModelSize::* member>
void add_deprecated(nb::class_<ModelSize>& size, const char* old_name, const char* name) {
  const std::string message = std::string("ModelSize.") + old_name + " is deprecated and will be removed in the next " +
                              "release; use ModelSize." + name;
  size.def_prop_ro(old_name, [message](const ModelSize& self) {
    if (PyErr_WarnEx(PyExc_DeprecationWarning, message.c_str(), 1) < 0) throw nb::python_error();
    return self.*member;
  });
}

void bind_size(nb::module_& m) {
  nb::class_<ModelSize> size(m, "ModelSize", "Sizes of the model of a scene.");
  size.def_ro("bodies", &ModelSize::bodies, "Number of bodies that can move; welded bodies count as one.")
      .def_ro("coordinates", &ModelSize::coordinates, "Number of joint coordinates of the tree.")
      .def_ro("velocities", &ModelSize::speeds, "Number of generalized velocities of the tree.")
      .def_ro("constraint_equations", &ModelSize::rows, "Number of constraint equations.")
      .def_ro("rank", &ModelSize::rank, "Rank of the constraint equations.")
      .def_ro("degrees_of_freedom", &ModelSize::degrees_of_freedom, "velocities - rank.")
      .def_ro("free_coordinates", &ModelSize::free_coordinates,
              "Number of independent coordinates: degrees_of_freedom, and more where wheels roll.")
      .def_prop_ro("states", &ModelSize::states, "Smallest number of states: of the motion, and of elements.")
      .def_ro("element_states", &ModelSize::element_states, "Number of states of elements, such as currents.")
      .def_ro("islands", &ModelSize::islands, "Number of islands: parts without coupling, integrated separately.")
      .def_ro("planar_islands", &ModelSize::planar_islands, "Number of islands that are computed in their plane.")
      .def_ro("planar", &ModelSize::planar, "Whether all islands are computed in their plane.");
  add_deprecated<&ModelSize::speeds>(size, "speeds", "velocities");
  add_deprecated<&ModelSize::rows>(size, "rows", "constraint_equations");
  add_deprecated<&ModelSize::degrees_of_freedom>(size, "freedoms", "degrees_of_freedom");
}

}  // namespace

void gelenk::bind_signals(nb::module_& m) {
  bind_signal(m);
  bind_size(m);
}
