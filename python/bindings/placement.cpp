// SPDX-License-Identifier: BSD-3-Clause
// Simulations at states that are given, not reached by steps.
#include "simulation/placement.h"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bindings.h"
#include "plant.h"

namespace nb = nanobind;
using gelenk::Placement;
using gelenk::SharedSimulation;
using gelenk::Simulation;

namespace {

using Matrix = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

struct Held {
  std::shared_ptr<const Placement::Position> position;
};

void read(Simulation& simulation, const std::vector<int>& outputs, std::vector<double>& out) {
  for (const double rate : Placement(simulation).rates()) out.push_back(rate);
  for (const int i : outputs) out.push_back(simulation.output(i));
}

// Moves all plants to the states, the inputs and the time of `leader`; a row for each: the rates of the states, then
// the outputs. names: of the plants, for messages.
Matrix follow_all(const std::vector<SharedSimulation*>& plants, const std::vector<std::string>& names,
                  SharedSimulation& leader, const std::vector<double>& x, const std::vector<int>& outputs) {
  for (const SharedSimulation* plant : plants) {
    const auto size = static_cast<int>(plant->fixed().outputs().size());
    if (std::ranges::any_of(outputs, [&](int i) { return i < 0 || i >= size; }))
      throw nb::index_error("an index of an output is out of range");
  }
  if (names.size() != plants.size()) throw nb::index_error("there are not as many names as plants");
  auto* values = new std::vector<double>;
  const nb::capsule owner(values, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  for (std::size_t k = 0; k < plants.size(); ++k) {
    try {
      plants[k]->with([&](Simulation& s) {
        Placement(s).follow(leader.fixed(), x);
        read(s, outputs, *values);
      });
    } catch (const gelenk::UsageError& fault) {
      throw gelenk::UsageError(names[k] + ": " + fault.what());
    } catch (const gelenk::StepError& fault) {
      throw gelenk::UsageError(names[k] + ": " + fault.what());
    }
  }
  const std::size_t columns = x.size() + outputs.size();
  return Matrix(values->data(), {plants.size(), columns}, owner);
}

}  // namespace

void gelenk::bind_placement(nb::module_& m, nb::class_<SharedSimulation>& simulation) {
  const nb::class_<Held> position(m, "Position", "Where a plant is.");
  simulation
      .def(
          "assemble", [](SharedSimulation& p, double time) { p.with([&](Simulation& s) { s.assemble(time); }); },
          nb::arg("time") = 0.0, "Like initialize(), without integrators: steps cannot be made.")
      .def(
          "move_to",
          [](SharedSimulation& p, const std::vector<double>& x, double time) {
            p.with([&](Simulation& s) { Placement(s).move_to(x, time); });
          },
          nb::arg("x"), nb::arg("time"),
          "After assemble(): move to these states, in the order of _states(). Raises UsageError; the simulation is "
          "then "
          "where it was.")
      .def(
          "position",
          [](SharedSimulation& p) { return Held{p.with([](Simulation& s) { return Placement(s).position(); })}; },
          "After assemble(): where it is, for return_to().")
      .def(
          "return_to",
          [](SharedSimulation& p, const Held& at) {
            p.with([&](Simulation& s) { Placement(s).return_to(*at.position); });
          },
          nb::arg("position"), "Move to where position() was called, of this plant or of a copy.")
      .def(
          "start_from",
          [](SharedSimulation& p, SharedSimulation& other, const std::vector<double>& x) {
            p.with([&](Simulation& s) { Placement(s).start_from(other.fixed(), x); });
          },
          nb::arg("other"), nb::arg("x"),
          "After initialize(): make the next step from the time, inputs and modes of another plant, at these states, "
          "in the order of _states(). Raises UsageError.")
      .def(
          "modes", [](SharedSimulation& p) { return p.with([](Simulation& s) { return Placement(s).modes(); }); },
          "After assemble(): what has modes that change at events; empty: nothing.")
      .def(
          "rates", [](SharedSimulation& p) { return p.with([](Simulation& s) { return Placement(s).rates(); }); },
          "Time derivatives of the states.");
  m.def("follow_all", follow_all, nb::arg("plants"), nb::arg("names"), nb::arg("leader"), nb::arg("x"),
        nb::arg("outputs"),
        "Move assembled plants to the states, inputs and time of another one; a row for each: the time derivatives of "
        "the states, then the outputs. Raises UsageError with the name of a plant that cannot follow.");
}
