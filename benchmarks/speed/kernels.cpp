// SPDX-License-Identifier: BSD-3-Clause
// Times the kernels of Gelenk on a scene: gelenk-kernels SCENE.json SECONDS_OF_A_CALL, the longest that is measured.
// gelenk-kernels SCENE.json evaluate CALLS: repeats forward dynamics for a profiler.
// Prints a line of JSON for each: {"kernel": ..., "us": ..., "ref_us": ...}, or the reason of a failure. The kernels:
//   positions         set_position: poses and constraint errors
//   constraint equations  positions, and set_velocity: velocities, rates of the constraints and velocity products
//   inverse dynamics  constraint equations, and set_acceleration: accelerations and the wrench of every joint
//   mass matrix       constraint equations, and assemble: M (full), J, tau - h
//   factorize         positions, and M, J and their factors
//   forward dynamics  one evaluation of ydot = f(t, y), all islands, as an integrator calls it
//   derivatives       df/dy, exact
//   projection        projection onto the constraints from a nearby state
//   step METHOD       1 ms of the simulation after a jump of an input
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "integrator/integrator.h"
#include "preparation/loads.h"
#include "scene_file/read.h"
#include "simulation/probe.h"
#include "simulation/simulation.h"
#include "simulation/start_report.h"
#include "timing.h"

namespace {

using gelenk::Simulation;

double longest = 1;  // s

void print(const std::string& kernel, double seconds) {
  std::printf(R"({"kernel": "%s", "us": %.6g, "ref_us": %.6g})"
              "\n",
              kernel.c_str(), 1e6 * seconds, 1e6 * ref_kernel(100));
  std::fflush(stdout);
}

// Prints the reason of a failure; quotation marks would end the JSON string.
void print_fault(const std::string& kernel, std::string why) {
  for (char& c : why) {
    if (c == '"' || c == '\\' || c == '\n') c = ' ';
  }
  std::printf(R"({"kernel": "%s", "fault": "%s"})"
              "\n",
              kernel.c_str(), why.c_str());
  std::fflush(stdout);
}

template <class Call>
void measure(const std::string& kernel, Call&& call) {
  try {
    const double begin = cpu_seconds();
    call();
    if (cpu_seconds() - begin > longest) return print_fault(kernel, "one call takes too long");
    print(kernel, least_time(call));
  } catch (const std::exception& fault) {
    print_fault(kernel, fault.what());
  }
}

// The state of an island; it changes slightly before each call, so that no cached result can be reused.
struct State {
  explicit State(std::vector<double> at) : start(std::move(at)), y(start), out(y.size()) {}
  const double* next() {
    y[0] = start[0] + 1e-9 * (++calls % 8);
    return y.data();
  }
  std::vector<double> start, y, out;
  int calls = 0;
};

void measure_dynamics(const gelenk::Mechanism& mechanism, const gelenk::Loads& loads, int rank, State& state,
                      const std::vector<double>& u) {
  const auto dynamics = gelenk::make_dynamics(mechanism, loads);
  dynamics->set_max_rank(rank);
  const auto nv = static_cast<std::size_t>(mechanism.nv);
  const double* v = state.start.data() + mechanism.nq;
  std::vector<double> vdot(nv), f(nv);
  dynamics->set_position(state.next());
  dynamics->factorize();
  dynamics->set_velocity(v);
  dynamics->solve(u.data(), vdot.data());
  measure("positions", [&] { dynamics->set_position(state.next()); });
  const auto rows = [&] {
    dynamics->set_position(state.next());
    dynamics->set_velocity(v);
  };
  measure("constraint equations", rows);
  measure("inverse dynamics", [&] {
    rows();
    dynamics->set_acceleration(vdot.data());
  });
  measure("factorize", [&] {
    dynamics->set_position(state.next());
    dynamics->factorize();
  });
  std::vector<double> M(nv * nv);
  measure("mass matrix", [&] {
    rows();
    dynamics->assemble(u.data(), M.data(), f.data());
  });
}

void measure_equations(Simulation& simulation, std::vector<State>& states) {
  gelenk::Probe probe(simulation);
  const int islands = static_cast<int>(states.size());
  measure("forward dynamics", [&] {
    for (int i = 0; i < islands; ++i) probe.equations(i).rhs(0, states[i].next(), states[i].out.data());
  });
  if (simulation.size().rows == 0) return;
  std::vector<double> y;
  measure("projection", [&] {
    for (int i = 0; i < islands; ++i) {
      y = states[i].start;
      for (double& x : y) x += 1e-7;
      if (!probe.equations(i).project(0, y.data())) throw std::runtime_error("not reached");
    }
  });
}

void measure_derivatives(Simulation& simulation, std::vector<State>& states) {
  gelenk::Probe probe(simulation);
  const int islands = static_cast<int>(states.size());
  std::vector<std::vector<double>> jacobians(states.size());
  measure("derivatives", [&] {
    for (int i = 0; i < islands; ++i) {
      jacobians[i].resize(states[i].y.size() * states[i].y.size());
      probe.equations(i).jacobian(0, states[i].next(), jacobians[i].data());
    }
  });
}

// Communication steps of 1 ms: the first input jumps slightly before each.
void measure_step(gelenk::Scene scene, const std::string& method) {
  const std::string kernel = "step " + method;
  try {
    scene.solver.integrator = method;
    scene.solver.step = 1e-3;
    Simulation simulation(scene);
    simulation.initialize();
    const bool driven = !simulation.inputs().empty();
    const double torque = driven ? simulation.input(0) : 0;
    long k = 0;
    measure(kernel, [&] {
      if (driven) simulation.set_input(0, torque + 1e-3 * static_cast<double>(k % 7));
      ++k;
      simulation.step_to(1e-3 * static_cast<double>(k));
    });
  } catch (const std::exception& fault) {
    print_fault(kernel, fault.what());
  }
}

// Methods that factorize a full matrix in all velocities are not measured on the largest scenes.
constexpr int implicit_at_most = 64;

gelenk::Scene scene_of(const char* file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return gelenk::read_scene_json(text.str(), file);
}

std::vector<State> states_of(Simulation& simulation) {
  const gelenk::Probe probe(simulation);
  std::vector<State> states;
  for (int i = 0; i < simulation.size().islands; ++i) states.emplace_back(probe.state(i));
  return states;
}

void evaluate(const char* file, long calls) {
  Simulation simulation(scene_of(file));
  simulation.initialize();
  auto states = states_of(simulation);
  gelenk::Probe probe(simulation);
  for (long k = 0; k < calls; ++k) {
    for (int i = 0; i < simulation.size().islands; ++i) {
      probe.equations(i).rhs(0, states[i].next(), states[i].out.data());
    }
  }
}

void run(const char* file) {
  const gelenk::Scene scene = scene_of(file);
  Simulation simulation(scene);
  const double begin = cpu_seconds();
  simulation.initialize();
  const gelenk::ModelSize size = simulation.size();
  std::printf(R"({"kernel": "size", "speeds": %d, "rows": %d, "rank": %d, "planar": %d, "start_s": %.3g})"
              "\n",
              size.speeds, size.rows, size.rank, size.planar, cpu_seconds() - begin);
  const gelenk::StartReport report(simulation);
  const gelenk::PreparedScene& prepared = report.prepared();
  auto states = states_of(simulation);
  measure_equations(simulation, states);
  const auto loads = gelenk::make_loads(scene, prepared.reduced);
  const std::vector<double> u(simulation.inputs().size());
  if (size.islands == 1) {
    measure_dynamics(prepared.islands[0].mechanism, loads[0], prepared.islands[0].mobility.rank, states[0], u);
  }
  for (const auto& kind : gelenk::integrator_kinds()) {
    const std::string method(kind.name);
    if (size.speeds <= implicit_at_most || method == "auto" || method == "erk" || method == "rk4" ||
        method == "euler") {
      measure_step(scene, method);
    }
  }
  measure_derivatives(simulation, states);  // last: a full matrix, which may not fit into memory for the largest scenes
}

}  // namespace

int main(int argc, char** argv) {
  const bool evaluates = argc == 4 && std::strcmp(argv[2], "evaluate") == 0;
  if (argc != 3 && !evaluates) {
    std::fputs("usage: gelenk-kernels SCENE.json SECONDS_OF_A_CALL | evaluate CALLS\n", stderr);
    return 2;
  }
  longest = std::atof(argv[2]);
  try {
    if (evaluates) {
      evaluate(argv[1], std::atol(argv[3]));
    } else {
      run(argv[1]);
    }
  } catch (const std::exception& fault) {
    print_fault("start", fault.what());
    return 1;
  }
  return 0;
}
