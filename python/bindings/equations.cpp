// SPDX-License-Identifier: BSD-3-Clause
#include "equations/scene_equations.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string>
#include <tuple>
#include <vector>

#include "bindings.h"

namespace nb = nanobind;
using gelenk::EquationArgument;
using gelenk::EquationValues;
using gelenk::Scene;
using gelenk::SceneEquations;
using gelenk::TracedScene;
using namespace nb::literals;

namespace {

// By gelenk::expression::Operation.
constexpr std::array operation_names = {
    "constant", "variable", "add",   "subtract", "multiply", "divide", "negate", "integer_power", "power", "choose",
    "lookup",   "sin",      "cos",   "tan",      "asin",     "acos",   "atan",   "atan2",         "sinh",  "cosh",
    "tanh",     "asinh",    "acosh", "atanh",    "exp",      "log",    "log10",  "sqrt",          "cbrt",  "erf"};
static_assert(operation_names.size() == static_cast<std::size_t>(gelenk::expression::Operation::erf) + 1);

using NodeTuple = std::tuple<std::string, std::vector<int>, int, double>;

// Each node: operation, operands, index of a variable or exponent, value of a constant.
std::vector<NodeTuple> nodes(const TracedScene& scene) {
  std::vector<NodeTuple> out;
  const gelenk::expression::Graph& graph = scene.equations().graph;
  for (int term = 0; term < graph.size(); ++term) {
    const gelenk::expression::Node& node = graph[term];
    std::vector<int> of;
    for (const int operand : node.of) {
      if (operand >= 0) of.push_back(operand);
    }
    out.emplace_back(operation_names[static_cast<std::size_t>(node.operation)], of, node.index, node.value);
  }
  return out;
}

}  // namespace

void gelenk::bind_equations(nb::module_& m) {
  nb::class_<EquationArgument>(m, "EquationArgument", "A number on which equations depend.")
      .def_ro("name", &EquationArgument::name)
      .def_ro("unit", &EquationArgument::unit)
      .def_ro("text", &EquationArgument::text)
      .def_ro("start", &EquationArgument::start);
  nb::class_<EquationValues>(m, "EquationValues", "Values of equations by the kernels of simulations.")
      .def_ro("M", &EquationValues::M)
      .def_ro("J", &EquationValues::J)
      .def_ro("h", &EquationValues::h)
      .def_ro("gamma", &EquationValues::gamma)
      .def_ro("Phi", &EquationValues::Phi)
      .def_ro("rate", &EquationValues::rate)
      .def_ro("qdot", &EquationValues::qdot)
      .def_ro("rates", &EquationValues::rates)
      .def_ro("vdot", &EquationValues::vdot)
      .def_ro("lambda_", &EquationValues::lambda)
      .def_ro("kinetic", &EquationValues::kinetic)
      .def_ro("potential", &EquationValues::potential);
  const auto list = [](auto member) { return [member](const TracedScene& s) { return s.equations().*member; }; };
  nb::class_<TracedScene>(m, "TracedScene", "The equations of a scene as expressions.")
      .def(nb::init<const Scene&>(), nb::call_guard<nb::gil_scoped_release>())
      .def("nodes", &nodes, "The graph: operation, operands, index and constant of each node.")
      .def("values", &TracedScene::values, "q"_a, "v"_a, "u"_a, nb::call_guard<nb::gil_scoped_release>(),
           "The values by the kernels of simulations.")
      .def_prop_ro("q", list(&SceneEquations::q))
      .def_prop_ro("v", list(&SceneEquations::v))
      .def_prop_ro("u", list(&SceneEquations::u))
      .def_prop_ro("rows", list(&SceneEquations::rows))
      .def_prop_ro("states", list(&SceneEquations::states))
      .def_prop_ro("M", list(&SceneEquations::M))
      .def_prop_ro("J", list(&SceneEquations::J))
      .def_prop_ro("h", list(&SceneEquations::h))
      .def_prop_ro("gamma", list(&SceneEquations::gamma))
      .def_prop_ro("Phi", list(&SceneEquations::Phi))
      .def_prop_ro("rate", list(&SceneEquations::rate))
      .def_prop_ro("qdot", list(&SceneEquations::qdot))
      .def_prop_ro("rates", list(&SceneEquations::rates))
      .def_prop_ro("kinetic", list(&SceneEquations::kinetic))
      .def_prop_ro("potential", list(&SceneEquations::potential))
      .def_prop_ro("notes", list(&SceneEquations::notes));
}
