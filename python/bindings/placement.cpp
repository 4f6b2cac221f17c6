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
using gelenk::Plant;
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

// Assembled plants that are placed beside another one.
class Followers {
 public:
  // names: of the plants, for messages. outputs: indices of those that are read.
  Followers(std::vector<Plant*> plants, std::vector<std::string> names, std::vector<int> outputs)
      : plants_(std::move(plants)), names_(std::move(names)), outputs_(std::move(outputs)) {
    if (names_.size() != plants_.size()) throw nb::index_error("there are not as many names as plants");
    for (Plant* plant : plants_) {
      const auto size = static_cast<int>(plant->fixed().outputs().size());
      if (std::ranges::any_of(outputs_, [&](int i) { return i < 0 || i >= size; }))
        throw nb::index_error("an index of an output is out of range");
      plant->with([&](Simulation& s) { placements_.emplace_back(s); });
    }
  }

  // Moves all plants to the states, the inputs and the time of `leader`; a row for each: the rates of the states, then
  // the outputs.
  Matrix follow(Plant& leader, const std::vector<double>& x) {
    auto* values = new std::vector<double>;
    const nb::capsule owner(values, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    for (std::size_t k = 0; k < plants_.size(); ++k) {
      try {
        plants_[k]->with([&](Simulation& s) {
          placements_[k].follow(leader.fixed(), x);
          read(s, outputs_, *values);
        });
      } catch (const gelenk::UsageError& fault) {
        throw gelenk::UsageError(names_[k] + ": " + fault.what());
      } catch (const gelenk::StepError& fault) {
        throw gelenk::UsageError(names_[k] + ": " + fault.what());
      }
    }
    return Matrix(values->data(), {plants_.size(), x.size() + outputs_.size()}, owner);
  }

 private:
  std::vector<Plant*> plants_;
  std::vector<std::string> names_;
  std::vector<int> outputs_;
  std::vector<Placement> placements_;
};

}  // namespace

void gelenk::bind_placement(nb::module_& m, nb::class_<Plant>& simulation) {
  nb::class_<Held>(m, "Position", "Where a plant is.");
  simulation
      .def(
          "assemble", [](Plant& p, double time) { p.with([&](Simulation& s) { s.assemble(time); }); },
          nb::arg("time") = 0.0, "Like initialize(), without integrators: steps cannot be made.")
      .def(
          "move_to",
          [](Plant& p, const std::vector<double>& x, double time) {
            p.with([&](Simulation& s) { Placement(s).move_to(x, time); });
          },
          nb::arg("x"), nb::arg("time"),
          "After assemble(): move to these states, in the order of _states(). Raises UsageError; the simulation is "
          "then "
          "where it was.")
      .def(
          "position", [](Plant& p) { return Held{p.with([](Simulation& s) { return Placement(s).position(); })}; },
          "After assemble(): where it is, for return_to().")
      .def(
          "return_to",
          [](Plant& p, const Held& at) { p.with([&](Simulation& s) { Placement(s).return_to(*at.position); }); },
          nb::arg("position"), "Move to where position() was called, of this plant or of a copy.")
      .def(
          "modes", [](Plant& p) { return p.with([](Simulation& s) { return Placement(s).modes(); }); },
          "After assemble(): what has modes that change at events; empty: nothing.")
      .def(
          "rates", [](Plant& p) { return p.with([](Simulation& s) { return Placement(s).rates(); }); },
          "Time derivatives of the states.");
  nb::class_<Followers>(m, "Followers", "Assembled plants that are placed beside another one.")
      .def(nb::init<std::vector<Plant*>, std::vector<std::string>, std::vector<int>>(), nb::arg("plants"),
           nb::arg("names"), nb::arg("outputs"), nb::keep_alive<1, 2>(),
           "plants: must outlive this. names: for messages. outputs: indices of those that are read.")
      .def("follow", &Followers::follow, nb::arg("leader"), nb::arg("x"),
           "Move to the states x, the inputs and the time of `leader`; a row for each plant: the time derivatives of "
           "the "
           "states, then the outputs. Raises UsageError with the name of a plant that cannot follow.");
}
