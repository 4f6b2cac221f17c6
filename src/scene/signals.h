// SPDX-License-Identifier: BSD-3-Clause
// The names of what goes into and comes out of a scene: one list each, in one order, for the FMU's
// variables, Python's tables and CSV columns alike.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

struct Signal {
  std::string name;         // "A.phi", "drive.tau", "C.f[1]"
  std::string unit;         // FMI spelling; "" or "1": none
  std::string description;  // one sentence
  double start = 0;         // of an input
  Stage stage = Stage::position;
  // Joint states only: which joint, 0 coordinate, 1 speed, 2 acceleration, and its place there; else -1.
  int joint = -1;
  int level = -1;
  int component = -1;  // also of an element's group
  // Of an element: its section, place in it, group of its signals; else -1.
  int section = -1;
  int element = -1;
  int group = -1;
};

// In the order of the sections and the file.
std::vector<Signal> input_signals(const Scene& scene);
// By section and element: the number of its first input.
std::vector<std::vector<int>> first_inputs(const Scene& scene);

// Joints in file order (coordinates, speeds, accelerations), then sensors in file order, then constraints.
std::vector<Signal> output_signals(const Scene& scene);

// Health of a run, the same for each scene: the order of diagnostic_signals().
enum class Diagnostic : int {
  constraint_position,  // largest |Phi| over all constraint rows: m and rad alike
  constraint_velocity,  // largest |J v - b| over these rows: m/s and rad/s alike
  kinetic_energy,       // J
  potential_energy,     // J, gravity, springs and stops
  total_energy,         // J
  steps,                // of the integrator since initialize()
  evaluations,          // of the equations of motion since initialize()
  rejected_steps,       // tried and given up, since initialize()
  jacobians,            // exact df/dy made for implicit methods, since initialize()
  singular_positions,   // passed since initialize(), where a loop's rows lose rank for a moment
  events,               // since initialize(): stops that were met or left, singular positions
};
inline constexpr int diagnostic_count = 11;

std::vector<Signal> diagnostic_signals();

}  // namespace gelenk
