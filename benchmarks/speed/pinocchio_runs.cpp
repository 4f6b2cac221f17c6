// SPDX-License-Identifier: BSD-3-Clause
// Pinocchio on a tree:
//   pinocchio-runs forward TREE            us of one evaluation, by every algorithm for the mechanism
//   pinocchio-runs step TREE               us of 1 ms with a new torque: rk4, and DOP853 at 1e-6
//   pinocchio-runs run TREE TOLERANCE ...  DOP853 with projection after each step
//   pinocchio-runs accelerations TREE      vdot at the start
#include <cstdlib>
#include <cstring>
#include <exception>

#include "dop853.h"
#include "pinocchio_model.h"
#include "runs.h"
#include "timing.h"

namespace {

// end: the joint coordinates after the communication steps.
void print_time(const char* kernel, double seconds, const VectorXd& end = {}) {
  std::printf(R"({"kernel": "%s", "us": %.6g, "ref_us": %.6g, "end": [)", kernel, 1e6 * seconds, 1e6 * ref_kernel(100));
  for (int i = 0; i < end.size(); ++i) std::printf(i == 0 ? "%.17g" : ", %.17g", end[i]);
  std::printf("]}\n");
  std::fflush(stdout);
}

void forward(const TreeFile& tree) {
  const bool loops = !tree.closures.empty();
  for (const bool proximal : {false, true}) {
    // constraintDynamics takes no external forces.
    if (proximal && (!loops || !tree.springs.empty())) continue;
    PinocchioModel model(tree, proximal);
    VectorXd q = model.q0(), vdot = model.v0();
    const VectorXd v = model.v0();
    int k = 0;
    const auto call = [&] {
      q[0] = tree.bodies[0].q + 1e-9 * (++k % 8);
      model.acceleration(0, q, v, vdot);
    };
    print_time(proximal ? "constraintDynamics" : loops ? "crba + rows" : "aba", least_time(call, 0.05));
  }
}

void rk4_step(PinocchioModel& model, double t, double h, VectorXd& q, VectorXd& v) {
  static VectorXd a1, a2, a3, a4, v2, v3, v4;
  model.acceleration(t, q, v, a1);
  v2 = v + h / 2 * a1;
  model.acceleration(t + h / 2, q + h / 2 * v, v2, a2);
  v3 = v + h / 2 * a2;
  model.acceleration(t + h / 2, q + h / 2 * v2, v3, a3);
  v4 = v + h * a3;
  model.acceleration(t + h, q + h * v3, v4, a4);
  q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
  v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
}

void step(const TreeFile& tree) {
  PinocchioModel model(tree, false);
  VectorXd q = model.q0(), v = model.v0();
  long k = 0;
  const auto torque = [&] {
    VectorXd out(model.size());
    for (int i = 0; i < model.size(); ++i) {
      out[i] = tree.bodies[static_cast<std::size_t>(i)].torque(1e-3 * static_cast<double>(k));
    }
    int moved = 0;
    while (tree.bodies[static_cast<std::size_t>(moved)].tau == 0 &&
           tree.bodies[static_cast<std::size_t>(moved)].amplitude == 0) {
      ++moved;
    }
    out[moved] += 1e-3 * static_cast<double>(k % 7);
    return out;
  };
  const auto one = [&](auto&& advance) {
    // The torques are computed by the caller and not part of the measurement.
    double spent = 0;
    for (int i = 0; i < 500; ++i) {
      model.hold(torque());
      const double begin = cpu_seconds();
      advance();
      spent += cpu_seconds() - begin;
      ++k;
    }
    return spent / 500;
  };
  const double clock = least_time([] { cpu_seconds(); }, 0.001);
  const auto least = [&](auto&& advance) {
    double found = 1e30;
    for (int round = 0; round < 7; ++round) {
      q = model.q0(), v = model.v0();
      k = 0;
      found = std::min(found, one(advance) - clock);
    }
    return found;
  };
  const double rk4 = least([&] {
    rk4_step(model, 0, 1e-3, q, v);
    if (model.has_loops()) model.project(q, v);
  });
  print_time("rk4", rk4, q);
  Dop853 dop853(model, 1e-6);
  const double adaptive = least([&] {
    dop853.start(0, q, v, 1e-3);
    dop853.advance(1e-3);
    q = dop853.q(), v = dop853.v();
  });
  print_time("dop853 at 1e-6", adaptive, q);
}

RunRecord run_once(const TreeFile& tree, double tolerance) {
  PinocchioModel model(tree, false);
  Dop853 dop853(model, tolerance);
  RunRecord run;
  run.method = "dop853";
  run.setting = tolerance;
  const auto sample = [&](const VectorXd& q) { run.samples.emplace_back(q.begin(), q.end()); };
  sample(model.q0());
  const double begin = cpu_seconds();
  dop853.start(0, model.q0(), model.v0());
  run.finished = true;
  for (int k = 1; k <= tree.samples() && run.finished; ++k) {
    run.finished = dop853.advance(k * tree.sample) && cpu_seconds() - begin < 20;
    sample(dop853.q());
  }
  run.cpu = cpu_seconds() - begin;
  run.steps = dop853.steps();
  run.evaluations = model.evaluations();
  return run;
}

void run(const TreeFile& tree, double tolerance) {
  RunRecord best;
  for (int round = 0; round < 5; ++round) {
    RunRecord found = run_once(tree, tolerance);
    if (found.cpu < best.cpu) best = std::move(found);
    if (best.cpu > 0.3) break;
  }
  print(best);
}

void accelerations(const TreeFile& tree) {
  PinocchioModel model(tree, false);
  VectorXd vdot(model.size());
  model.acceleration(0, model.q0(), model.v0(), vdot);
  for (const double x : vdot) std::printf("%.17g\n", x);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  try {
    const TreeFile tree = read_tree(argv[2]);
    if (std::strcmp(argv[1], "forward") == 0) forward(tree);
    if (std::strcmp(argv[1], "step") == 0) step(tree);
    if (std::strcmp(argv[1], "accelerations") == 0) accelerations(tree);
    if (std::strcmp(argv[1], "run") == 0) {
      for (int i = 3; i < argc; ++i) run(tree, std::atof(argv[i]));
    }
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return 1;
  }
  return 0;
}
