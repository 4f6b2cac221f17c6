// SPDX-License-Identifier: BSD-3-Clause
// Inputs, outputs and diagnostics of a scene. FMU variables, Python tables and CSV columns all use these lists, in this
// order.
#pragma once

#include <string>
#include <vector>

#include "element/element.h"

namespace gelenk {

struct Scene;

struct Signal {
  std::string name;         // "A.phi", "drive.tau", "C.f[1]"
  std::string unit;         // spelled as in FMI; "" or "1" if dimensionless
  std::string description;  // one sentence
  double start = 0;         // start value of an input
  Stage stage = Stage::position;
  // Signals of joints only: joint; level 0 (coordinate), 1 (velocity), 2 (acceleration) or 3 (of an element along it);
  // index within the joint. Else -1.
  int joint = -1;
  int level = -1;
  int component = -1;   // also the index within a group of an element
  int derivative = -1;  // of an output: index of the output that is its time derivative; else -1
  // Signals of elements only: section, index of the element in it (level 3: its kind among joint_force_kinds()), group
  // of signals. Else -1.
  int section = -1;
  int element = -1;
  int group = -1;
};

// Returns the inputs in the order of the sections and the file, then those of joints (clutches, brakes) and of no
// element.
std::vector<Signal> input_signals(const Scene& scene);
// Returns, for each section and element, then for the joints, the index of the first input; last, alone, that of the
// first input of no element.
std::vector<std::vector<int>> first_inputs(const Scene& scene);

// Returns the outputs: joints in file order (coordinates, velocities, accelerations, friction and limits), then
// sensors, motors, forces, constraints, contacts and element states in file order.
std::vector<Signal> output_signals(const Scene& scene);

// Outputs that describe the computation itself; the same for every scene, in the order of diagnostic_signals().
enum class Diagnostic : int {
  constraint_position,  // largest |Phi| over all constraint equations, m or rad
  constraint_velocity,  // largest |J v - b| over all constraint equations, m/s or rad/s
  kinetic_energy,       // J
  potential_energy,     // J, gravity, springs and stops
  total_energy,         // J
  steps,                // integrator steps since initialize()
  evaluations,          // evaluations of the equations of motion since initialize()
  rejected_steps,       // rejected integrator steps since initialize()
  jacobians,            // evaluations of the exact Jacobian df/dy since initialize()
  singular_positions,   // singular configurations crossed since initialize(), where the constraint Jacobian momentarily
                        // loses rank
  events,               // since initialize(): changes of mode and singular configurations crossed
  impacts,              // since initialize(): of coordinates on their limits
  zeno,                 // since initialize(): series of impacts that have ended in contact
  ambiguous,            // since initialize(): changes of mode with more than one consistent outcome, or none
  cone_residual,        // m/s, of steps with impulses: the largest of the last communication step
  cone_iterations,      // the most for one cone problem of the last communication step
  contact_points,       // that transmit a force at the end of the last step
  scheme,               // of contacts: 0: located events, 1: steps with impulses
  step_error,           // of the latter with the integrator auto: estimated error of positions [rad, m]
  law_excess,           // at present, of forces beyond their laws; 1: as much as is permitted
  worst_step,           // the most evaluations in one communication step since initialize()
  traced,               // of the evaluations: those by a program that was made for the scene
};
inline constexpr int diagnostic_count = 22;

// Returns the diagnostics in the order of Diagnostic.
std::vector<Signal> diagnostic_signals();

}  // namespace gelenk
