// SPDX-License-Identifier: BSD-3-Clause
// gelenk-runs SCENE.json TREE.txt METHOD=SETTING ...: runs the scene as a co-simulation master would, and prints
// its joint coordinates at the samples of TREE.
//   METHOD   FORMULATION+INTEGRATOR, as "projection+auto"
//   SETTING  tolerance; the step [s] of methods with fixed steps
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <numbers>
#include <sstream>

#include "runs.h"
#include "scene_file/read.h"
#include "simulation/simulation.h"
#include "tree_file.h"

namespace {

using gelenk::Simulation;

gelenk::Scene read_scene(const char* file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return gelenk::read_scene_json(text.str(), file);
}

// Indices of the outputs with the joint coordinates, in the order of the bodies.
std::vector<int> coordinates(const Simulation& simulation, const TreeFile& tree) {
  std::vector<int> found;
  for (const TreeBody& b : tree.bodies) {
    const std::string name = "j_" + b.name + (b.slides ? ".s" : ".phi");
    for (std::size_t i = 0; i < simulation.outputs().size(); ++i) {
      if (simulation.outputs()[i].name == name) found.push_back(static_cast<int>(i));
    }
  }
  if (found.size() != tree.bodies.size()) throw std::runtime_error("scene and tree have different joints");
  return found;
}

// A motor's input and the sine that it follows.
struct Drive {
  int input;
  TreeBody body;

  void set(Simulation& simulation, double t) const {
    simulation.set_input(input, body.torque(t));
    if (body.amplitude == 0) return;
    double scale = body.amplitude;
    for (int order = 1; order <= 5; ++order) {
      scale *= body.omega;
      const double phase = body.omega * t + body.phase + order * std::numbers::pi / 2;
      simulation.set_input_derivative(input, order, scale * std::sin(phase));
    }
  }
};

std::vector<Drive> drives(const Simulation& simulation, const TreeFile& tree) {
  std::vector<Drive> found;
  for (const TreeBody& b : tree.bodies) {
    for (std::size_t i = 0; i < simulation.inputs().size(); ++i) {
      if (simulation.inputs()[i].name.starts_with("m_" + b.name + ".")) found.push_back({static_cast<int>(i), b});
    }
  }
  return found;
}

// Communication steps per sample: sinusoidal torques are passed as Taylor polynomials of order 5, whose relative error
// over a step, (omega h)^6 / 720, has to be below the tolerance.
int steps_per_sample(const std::vector<Drive>& drives, const TreeFile& tree, double tolerance) {
  double fastest = 0;
  for (const Drive& drive : drives) {
    if (drive.body.amplitude != 0) fastest = std::max(fastest, drive.body.omega);
  }
  if (fastest == 0) return 1;
  const double longest = std::pow(720 * 0.1 * tolerance, 1.0 / 6) / fastest;
  return std::max(1, static_cast<int>(std::ceil(tree.sample / longest)));
}

RunRecord run_once(const gelenk::Scene& scene, const TreeFile& tree, double tolerance) {
  Simulation simulation(scene);
  const auto driven = drives(simulation, tree);
  for (const Drive& drive : driven) drive.set(simulation, 0);
  simulation.initialize(0, tolerance);
  const auto wanted = coordinates(simulation, tree);
  const int parts = steps_per_sample(driven, tree, tolerance);
  RunRecord run;
  run.cpu = 0;
  run.finished = true;
  const auto sample = [&] {
    std::vector<double> q;
    for (const int i : wanted) q.push_back(simulation.output(i));
    run.samples.push_back(std::move(q));
  };
  sample();
  for (int k = 0; k < tree.samples() && run.finished; ++k) {
    const double begin = cpu_seconds();
    try {
      for (int part = 0; part < parts; ++part) {
        for (const Drive& drive : driven) {
          if (part + k > 0 && drive.body.amplitude != 0) drive.set(simulation, simulation.time());
        }
        simulation.step_to(tree.sample * (k + (part + 1.0) / parts));
      }
    } catch (const std::exception&) {
      run.finished = false;
    }
    run.cpu += cpu_seconds() - begin;
    run.finished = run.finished && run.cpu < 20;
    sample();
  }
  using gelenk::Diagnostic;
  run.steps = std::lround(simulation.diagnostic(static_cast<int>(Diagnostic::steps)));
  run.evaluations = std::lround(simulation.diagnostic(static_cast<int>(Diagnostic::evaluations)));
  return run;
}

void run(gelenk::Scene scene, const TreeFile& tree, const std::string& method, double setting) {
  const auto plus = method.find('+');
  scene.solver.formulation = method.substr(0, plus);
  scene.solver.integrator = method.substr(plus + 1);
  // With fixed steps the setting is the step; torques are then accurate to 1e-8.
  const std::string& integrator = scene.solver.integrator;
  const bool fixed = integrator == "rk4" || integrator == "euler" || integrator == "generalized-alpha";
  if (fixed) scene.solver.step = setting;
  RunRecord best;
  for (int round = 0; round < 5; ++round) {
    RunRecord found = run_once(scene, tree, fixed ? 1e-8 : setting);
    if (found.cpu < best.cpu) best = std::move(found);
    if (best.cpu > 0.3) break;
  }
  best.method = method;
  best.setting = setting;
  print(best);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fputs("usage: gelenk-runs SCENE.json TREE.txt METHOD=SETTING ...\n", stderr);
    return 2;
  }
  try {
    const TreeFile tree = read_tree(argv[2]);
    for (int i = 3; i < argc; ++i) {
      const std::string word = argv[i];
      const auto equals = word.find('=');
      run(read_scene(argv[1]), tree, word.substr(0, equals), std::atof(word.c_str() + equals + 1));
    }
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return 1;
  }
  return 0;
}
