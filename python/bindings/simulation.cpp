// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/simulation.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.h"
#include "inspection/inspection.h"
#include "plant.h"
#include "scene/wanted_outputs.h"
#include "simulation/probe.h"
#include "simulation/start_report.h"
#include "simulation/state_derivatives.h"
#include "simulation/stepping_report.h"

namespace nb = nanobind;
using gelenk::check_index;
using gelenk::SharedSimulation;
using gelenk::Simulation;

namespace {

using Vector = nb::ndarray<nb::numpy, double, nb::ndim<1>>;

Vector to_numpy(std::vector<double>&& values) {
  auto* kept = new std::vector<double>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return Vector(kept->data(), {kept->size()}, owner);
}

Vector read_outputs(SharedSimulation& plant, const std::vector<int>& indices) {
  for (const int i : indices) check_index(i, plant.fixed().outputs().size());
  return to_numpy(plant.with([&](Simulation& s) {
    std::vector<double> values;
    values.reserve(indices.size());
    for (const int i : indices) values.push_back(s.output(i));
    return values;
  }));
}

std::vector<std::string> body_names(const SharedSimulation& plant) {
  std::vector<std::string> out;
  for (const gelenk::Body& body : plant.fixed().scene().bodies) out.push_back(body.name);
  return out;
}

Vector body_pose(SharedSimulation& plant, int body) {
  check_index(body, plant.fixed().scene().bodies.size());
  const gelenk::Pose3 X = plant.with([&](Simulation& s) { return s.body_pose(body); });
  std::vector<double> out;
  for (int i = 0; i < 3; ++i) out.insert(out.end(), {X.R(i, 0), X.R(i, 1), X.R(i, 2)});
  out.insert(out.end(), X.p.data(), X.p.data() + 3);
  return to_numpy(std::move(out));
}

Vector state_of(SharedSimulation& plant, int island) {
  return to_numpy(plant.with([&](Simulation& s) { return std::vector<double>(gelenk::Probe(s).state(island)); }));
}

// Consistent x and xdot at the present state, concatenated.
Vector consistent_at(SharedSimulation& plant, int island) {
  return to_numpy(plant.with([&](Simulation& s) {
    gelenk::Equations& equations = gelenk::Probe(s).equations(island);
    const std::size_t n = equations.unknowns();
    std::vector<double> out(gelenk::Probe(s).state(island));
    out.resize(2 * n);
    if (!equations.consistent(s.time(), out.data(), out.data() + n))
      throw gelenk::UsageError("the initial values could not be made consistent");
    return out;
  }));
}

// The residual F(x, xdot), or its Jacobians dF/dx and dF/dxdot, column by column.
Vector residual_of(SharedSimulation& plant, int island, const std::vector<double>& x, const std::vector<double>& xdot,
                   bool jacobian) {
  return to_numpy(plant.with([&](Simulation& s) {
    gelenk::Equations& equations = gelenk::Probe(s).equations(island);
    const std::size_t n = equations.unknowns();
    if (x.size() != n || xdot.size() != n)
      throw gelenk::UsageError("x, xdot: expected " + std::to_string(n) + " numbers each");
    std::vector<double> out(jacobian ? 2 * n * n : n);
    const bool found =
        jacobian ? equations.residual_jacobians(s.time(), x.data(), xdot.data(), out.data(), out.data() + n * n)
                 : equations.residual(s.time(), x.data(), xdot.data(), out.data());
    if (!found) throw gelenk::UsageError("x: the equations are not finite at this point");
    return out;
  }));
}

nb::bytes save(SharedSimulation& plant) {
  gelenk::Archive archive;
  plant.with([&](Simulation& s) { s.serialize(archive); });
  return nb::bytes(archive.words().data(), archive.words().size() * sizeof(std::uint64_t));
}

// Restores a saved state; if it is invalid, the simulation is unchanged.
void restore(SharedSimulation& plant, const nb::bytes& saved) {
  if (saved.size() % sizeof(std::uint64_t) != 0) throw gelenk::UsageError("saved: it is not of this plant, or damaged");
  std::vector<std::uint64_t> words(saved.size() / sizeof(std::uint64_t));
  std::memcpy(words.data(), saved.data(), words.size() * sizeof(std::uint64_t));
  gelenk::Archive archive(std::move(words));
  gelenk::Archive before;
  plant.with([&](Simulation& s) {
    s.serialize(before);
    try {
      s.serialize(archive);
      archive.finish();
    } catch (const std::invalid_argument& error) {
      before.start_reading();
      s.serialize(before);
      throw gelenk::UsageError(std::string("saved: ") + error.what());
    }
  });
}

// The right-hand side f(y), or its Jacobian df/dy column by column.
Vector derivatives_of(SharedSimulation& plant, int island, const std::vector<double>& y, bool jacobian) {
  return to_numpy(plant.with([&](Simulation& s) {
    gelenk::Equations& equations = gelenk::Probe(s).equations(island);
    const std::size_t n = equations.size();
    if (y.size() != n) throw gelenk::UsageError("y: expected " + std::to_string(n) + " numbers");
    std::vector<double> out(jacobian ? n * n : n);
    const bool found =
        jacobian ? equations.jacobian(s.time(), y.data(), out.data()) : equations.rhs(s.time(), y.data(), out.data());
    if (!found) throw gelenk::UsageError("y: the accelerations are not finite at this point");
    return out;
  }));
}

// The entries of a matrix, column by column.
Vector flattened(const Eigen::MatrixXd& from) {
  return to_numpy(std::vector<double>(from.data(), from.data() + from.size()));
}

// friction: name of a FrictionTreatment.
std::tuple<Vector, Vector, Vector, Vector, Vector, std::vector<int>> linearize(SharedSimulation& plant,
                                                                               const std::string& friction) {
  static constexpr std::string_view names[] = {"present", "locked", "sliding", "off"};
  const auto treatment = static_cast<gelenk::FrictionTreatment>(std::ranges::find(names, friction) - names);
  const gelenk::Linearization l =
      plant.with([&](Simulation& s) { return gelenk::StateDerivatives(s).linearize(treatment); });
  return {flattened(l.A), flattened(l.B), flattened(l.C), flattened(l.D), flattened(l.xdot), l.locked};
}

std::vector<Vector> residual_jacobians(SharedSimulation& plant, int island, const std::vector<double>& x,
                                       bool by_duals) {
  gelenk::Jacobians s =
      plant.with([&](Simulation& of) { return gelenk::Probe(of).residual_jacobians(island, x, by_duals); });
  std::vector<Vector> out;
  for (const Eigen::MatrixXd& part : {Eigen::MatrixXd(s.r), Eigen::MatrixXd(s.r_u), Eigen::MatrixXd(s.c),
                                      Eigen::MatrixXd(s.Phi_q), Eigen::MatrixXd(s.rate_q), s.qdot_q, s.qdot_v}) {
    out.push_back(flattened(part));
  }
  return out;
}

std::vector<Vector> directional_derivative(SharedSimulation& plant, const std::vector<double>& dx,
                                           const std::vector<double>& du) {
  const gelenk::DirectionalDerivative derivative =
      plant.with([&](Simulation& s) { return gelenk::StateDerivatives(s).directional_derivative(dx, du); });
  return {flattened(derivative.outputs), flattened(derivative.rates)};
}

Vector output_derivatives(SharedSimulation& plant, const std::vector<double>& udot, const std::vector<double>& uddot) {
  return flattened(
      plant.with([&](Simulation& s) { return gelenk::StateDerivatives(s).output_derivatives(udot, uddot); }));
}

void bind_inputs(nb::class_<SharedSimulation>& simulation) {
  simulation
      .def(
          "set_input",
          [](SharedSimulation& p, int index, double value) {
            check_index(index, p.fixed().inputs().size());
            p.with([&](Simulation& s) { s.set_input(index, value); });
          },
          nb::arg("index"), nb::arg("value"))
      .def(
          "input",
          [](SharedSimulation& p, int index) {
            check_index(index, p.fixed().inputs().size());
            return p.with([&](Simulation& s) { return s.input(index); });
          },
          nb::arg("index"))
      .def(
          "set_input_derivative",
          [](SharedSimulation& p, int index, int order, double value) {
            check_index(index, p.fixed().inputs().size());
            p.with([&](Simulation& s) { s.set_input_derivative(index, order, value); });
          },
          nb::arg("index"), nb::arg("order"), nb::arg("value"),
          "Time derivative of order 1 to 5 at `time`, which the input follows to the end of the next step.")
      .def(
          "input_derivative",
          [](SharedSimulation& p, int index, int order) {
            check_index(index, p.fixed().inputs().size());
            return p.with([&](Simulation& s) { return s.input_derivative(index, order); });
          },
          nb::arg("index"), nb::arg("order"));
}

void bind_checks(nb::class_<SharedSimulation>& simulation) {
  simulation.def("_state", state_of, nb::arg("island"), "(q, v) of an island; for checks.")
      .def("_state_jacobian", derivatives_of, nb::arg("island"), nb::arg("y"), nb::arg("jacobian"),
           "The right-hand side ydot at y as the integrator evaluates it, or d ydot / dy column by column; for checks.")
      .def("_residual_jacobians", residual_jacobians, nb::arg("island"), nb::arg("x"), nb::arg("by_duals"),
           "Jacobians of the island's residuals at x = (q, v, vdot, lambda): r, r_u, c, Phi_q, rate_q, qdot_q, qdot_v; "
           "for checks.")
      .def("_consistent", consistent_at, nb::arg("island"),
           "Consistent unknowns x = (q, v, multipliers) and xdot at the present state, concatenated; for checks.")
      .def("_residual", residual_of, nb::arg("island"), nb::arg("x"), nb::arg("xdot"), nb::arg("jacobian"),
           "The island's residual F(x, xdot), or dF/dx and dF/dxdot column by column; for checks.");
}

void bind_derivatives(nb::class_<SharedSimulation>& simulation) {
  simulation
      .def(
          "_states",
          [](SharedSimulation& p) {
            return p.with([](Simulation& s) { return gelenk::StateDerivatives(s).states(); });
          },
          "Indices of the outputs that are the states.")
      .def(
          "_take_states",
          [](SharedSimulation& p, const std::vector<int>& coordinates, const std::vector<int>& speeds) {
            for (const auto* taken : {&coordinates, &speeds}) {
              for (const int i : *taken) check_index(i, p.fixed().outputs().size());
            }
            p.with([&](Simulation& s) { gelenk::StateDerivatives(s).take_states({coordinates, speeds}); });
          },
          nb::arg("coordinates"), nb::arg("speeds"), "Select the states with respect to which derivatives are taken.")
      .def(
          "_linearize", linearize, nb::arg("friction") = "present",
          "The matrices A, B, C, D column by column, xdot, and the indices of the outputs that are coordinates at rest "
          "by friction or a limit.")
      .def("_directional_derivative", directional_derivative, nb::arg("dx"), nb::arg("du"),
           "Derivatives of the outputs and of the state derivatives in the direction (dx, du).")
      .def("_output_derivatives", output_derivatives, nb::arg("udot"), nb::arg("uddot"),
           "First, then second time derivatives of all outputs; udot, uddot: those of the inputs, [] for those set.");
}

// Outputs, events and poses of bodies.
void bind_readings(nb::class_<SharedSimulation>& simulation) {
  simulation.def_prop_ro("size", [](const SharedSimulation& p) { return p.fixed().size(); })
      .def_prop_ro("inputs", [](const SharedSimulation& p) { return p.fixed().inputs(); })
      .def_prop_ro("outputs", [](const SharedSimulation& p) { return p.fixed().outputs(); })
      .def_prop_ro(
          "wanted", [](const SharedSimulation& p) { return gelenk::wanted_outputs(p.fixed().scene()); },
          "For each output, whether the scene requests it.")
      .def_prop_ro("diagnostics", [](const SharedSimulation& p) { return p.fixed().diagnostics(); })
      .def_prop_ro("body_names", &body_names, "Names of the bodies in the order of the scene.")
      .def("body_pose", &body_pose, nb::arg("body"),
           "Pose of the frame of a body in the world frame: the rotation matrix, row by row, and the position [m].")
      .def("read_outputs", &read_outputs, nb::arg("indices"),
           "The values of the outputs with these indices, as an array.")
      .def(
          "diagnostic",
          [](SharedSimulation& p, int index) {
            check_index(index, p.fixed().diagnostics().size());
            return p.with([&](Simulation& s) { return s.diagnostic(index); });
          },
          nb::arg("index"))
      .def_prop_ro(
          "events",
          [](SharedSimulation& p) {
            std::vector<std::tuple<double, std::string>> out;
            for (const gelenk::EventReport& event : p.with([](Simulation& s) { return s.events(); })) {
              out.emplace_back(event.time, event.text);
            }
            return out;
          },
          "Events of the last step: pairs of time [s] and text.")
      .def_prop_ro("independent_coordinates",
                   [](SharedSimulation& p) {
                     return p.with([](Simulation& s) { return gelenk::StateDerivatives(s).independent().coordinates; });
                   })
      .def_prop_ro("independent_speeds", [](SharedSimulation& p) {
        return p.with([](Simulation& s) { return gelenk::StateDerivatives(s).independent().speeds; });
      });
}

// Reports on the model.
void bind_reports(nb::class_<SharedSimulation>& simulation) {
  simulation
      .def(
          "evaluation_cost",
          [](SharedSimulation& p) { return p.with([](Simulation& s) { return gelenk::Probe(s).evaluation_cost(); }); },
          "CPU time of one evaluation of the equations of motion at the present state [s], the smallest of several.")
      .def("_record_cone_problems",
           [](SharedSimulation& p, double end) {
             return p.with([&](Simulation& s) { return gelenk::Probe(s).record_cone_problems(end); });
           })
      .def(
          "inspect",
          [](SharedSimulation& p, const gelenk::Scene& whole) {
            return p.with([&](Simulation& s) { return gelenk::inspect(s, whole); });
          },
          nb::arg("whole"), "Report on the reductions; whole: the original scene. Requires initialize().")
      .def("moved_frames",
           [](SharedSimulation& p) {
             return p.with([](Simulation& s) { return gelenk::StartReport(s).moved_frames(); });
           })
      .def("start_warnings",
           [](SharedSimulation& p) { return p.with([](Simulation& s) { return gelenk::StartReport(s).warnings(); }); })
      .def(
          "run_warnings",
          [](SharedSimulation& p) {
            return p.with([](Simulation& s) { return gelenk::SteppingReport(s).warnings(); });
          },
          "Where time steps with impulses were used instead of located events, and their estimated error.")
      .def("assembly_report",
           [](SharedSimulation& p) { return p.with([](Simulation& s) { return gelenk::StartReport(s).assembly(); }); });
}

}  // namespace

void gelenk::bind_simulation(nb::module_& m) {
  bind_signals(m);
  nb::class_<SharedSimulation> simulation(m, "Simulation", "A running instance of a scene.");
  bind_inputs(simulation);
  bind_checks(simulation);
  bind_derivatives(simulation);
  bind_readings(simulation);
  bind_reports(simulation);
  bind_runs(m, simulation);
  bind_placement(m, simulation);
  bind_equilibria(m, simulation);
  bind_fleet(m);
  simulation.def(nb::init<const gelenk::Scene&>(), nb::arg("scene"))
      .def(
          "initialize",
          [](SharedSimulation& p, double time, double tolerance) {
            p.with([&](Simulation& s) { s.initialize(time, tolerance); });
          },
          nb::arg("time") = 0.0, nb::arg("tolerance") = 0.0,
          "Close the loops at the start values; tolerance 0: the scene's. Raises AssemblyError.")
      .def(
          "step_to", [](SharedSimulation& p, double end) { p.with([&](Simulation& s) { s.step_to(end); }); },
          nb::arg("end"),
          "Advance to end [s] with the present inputs. Raises StepError; the state is then that at `time`.")
      .def(
          "tune",
          [](SharedSimulation& p, const gelenk::Scene& scene) { p.with([&](Simulation& s) { s.tune(scene); }); },
          nb::arg("scene"),
          "Set the tunable parameters to their values in this scene, which is otherwise the original one; the effect "
          "is "
          "that of an input that jumps. Requires initialize(). Raises UsageError.")
      .def("save", save,
           "All data that determine how the run continues: time, state, inputs, memory of the methods. Saving does not "
           "change the run.")
      .def("restore", restore, nb::arg("saved"),
           "Restore data of save(), from this or another instance of the same scene with equal initialization: the "
           "same calls then give identical results. Raises UsageError for other data.")
      .def_prop_ro(
          "time", [](SharedSimulation& p) { return p.with([](Simulation& s) { return s.time(); }); }, "Time [s].");
}
