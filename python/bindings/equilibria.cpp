// SPDX-License-Identifier: BSD-3-Clause
// Equilibria and steady motions, and what holds a position at rest.
#include "analysis/equilibrium.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string>
#include <tuple>
#include <vector>

#include "plant.h"
#include "preparation/rest_forces.h"
#include "simulation/trim.h"

namespace nb = nanobind;
using gelenk::check_index;
using gelenk::SharedSimulation;
using gelenk::Simulation;

namespace {

// Of each coordinate with friction or a limit: its name, the unit of its forces, the force that keeps it at rest, the
// limit of its friction, and the side of the bound that it touches (2: a lock holds it); then whether these forces
// balance the load, and whether friction and contact can exert them. Of each point of contact: the names of its contact
// and of the bodies, its position, the force on the first one, the normal force, friction and its limit; whether all of
// them push, and a contact that is closed without points.
using RestForce = std::tuple<std::string, std::string, double, double, int>;
using RestPoint = std::tuple<std::string, std::string, std::string, std::array<double, 3>, std::array<double, 3>,
                             double, double, double>;
std::tuple<std::vector<RestForce>, bool, bool, std::vector<RestPoint>, bool, std::string> rest_forces(
    SharedSimulation& plant) {
  const gelenk::RestForces found = plant.with([](Simulation& s) { return s.rest_forces(); });
  std::vector<RestForce> out;
  for (const gelenk::RestForces::Of& of : found.coordinates) {
    out.emplace_back(of.coordinate, of.unit, of.force, of.limit, of.side);
  }
  const auto components = [](const Eigen::Vector3d& x) { return std::array<double, 3>{x[0], x[1], x[2]}; };
  std::vector<RestPoint> points;
  for (const gelenk::RestPoint& of : found.contacts.points) {
    points.emplace_back(of.contact, of.first, of.second, components(of.position), components(of.force), of.normal,
                        of.friction, of.limit);
  }
  return {out, found.is_balanced, found.is_held, points, found.contacts.can_push, found.contacts.undefined};
}

// How the search has ended, its steps, whether a prescribed motion may act, and the accelerations that remain.
std::tuple<std::string, int, bool, std::vector<std::tuple<int, double>>> trim(
    SharedSimulation& plant, const std::vector<std::tuple<int, double>>& held,
    const std::vector<std::tuple<int, double>>& solve_for, bool steady, const std::vector<int>& accelerations,
    bool only_approach) {
  static constexpr const char* ends[] = {"found", "not_converged", "none_near", "unreachable"};
  gelenk::EquilibriumRequest request{.steady = steady, .accelerations = accelerations, .only_approach = only_approach};
  for (const auto& [output, value] : held) {
    check_index(output, plant.fixed().outputs().size());
    request.held.push_back({output, value});
  }
  for (const auto& [input, size] : solve_for) {
    check_index(input, plant.fixed().inputs().size());
    request.solve_for.push_back({input, size});
  }
  for (const int output : accelerations) {
    check_index(output, plant.fixed().outputs().size());
    if (const gelenk::Signal& signal = plant.fixed().outputs()[static_cast<std::size_t>(output)]; signal.level != 2)
      throw gelenk::UsageError(signal.name + " is no acceleration of a joint");
  }
  const gelenk::Trim found = plant.with([&](Simulation& s) { return s.trim(request); });
  return {
      ends[static_cast<int>(found.end)], found.steps, found.is_driven, {found.residual.begin(), found.residual.end()}};
}

}  // namespace

void gelenk::bind_equilibria(nb::module_& m, nb::class_<SharedSimulation>& simulation) {
  m.attr("equilibrium_rate_tolerance") = gelenk::equilibrium_rate_tolerance;
  m.attr("equilibrium_rounding_tolerance") = gelenk::equilibrium_rounding_tolerance;
  simulation
      .def("_rest_forces", rest_forces,
           "What friction and limits have to do to keep the present position at rest, whether that balances the load, "
           "and whether they can.")
      .def(
          "_trim", trim, nb::arg("held"), nb::arg("solve_for"), nb::arg("steady"), nb::arg("accelerations"),
          nb::arg("only_approach"),
          "Search for an equilibrium from the present state: outputs to hold and their values, inputs to determine and "
          "the values of their own units; returns how it ended (found: the simulation is there), the steps, whether a "
          "prescribed motion may act, and the accelerations that remain, by output.");
}
