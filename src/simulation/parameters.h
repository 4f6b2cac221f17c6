// SPDX-License-Identifier: BSD-3-Clause
// The parameters of a scene, numbers that can be set before a simulation starts: the same table serves FMUs and the
// option `--set`.
//
// Start values of joints, gravity and solver settings are always parameters; other numbers only if the scene lists them
// under `parameters`, by their path in the file ("crank.mass", "A.damping"; an array as a whole: "crank.com").
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

enum class ParameterType { real, boolean, enumeration, integer };

struct Parameter {
  std::string name;         // "A.phi_start", "crank.m", "crank.com[1]"
  std::string unit;         // FMI spelling; empty: none
  std::string description;  // one sentence
  ParameterType type = ParameterType::real;
  std::vector<std::string> items;  // of an enumeration, in the order of its values 1, 2, ...
  std::vector<std::string> item_summaries;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool tunable = false;  // whether it may change during a run (Simulation::tune)
  // Whether it is a mass, a center of mass or a moment of inertia, or a tunable number of a joint, motor or force: no
  // position depends on it (RepeatedStart).
  bool keeps_positions = false;

  // Booleans are 0 or 1, enumerations the item's number, from 1. Use set_parameter() to set a value.
  std::function<double(const Scene&)> get;
  std::function<void(Scene&, double)> put;
};

// The parameters in this order: joint starts (joints in file order), gravity, solver, those listed in
// scene.parameters. Their functions work for every scene with the same bodies, joints, motors and forces. Throws
// SceneError for a listed path that is not that of a settable number.
std::vector<Parameter> scene_parameters(const Scene& scene);

// Throws std::invalid_argument with the parameter's name, the value found and the values allowed.
void check_parameter(const Parameter& parameter, double value);

// Throws what check_parameter() throws; the scene is then unchanged. Setting the present value has no effect (a guess
// remains a guess).
void set_parameter(Scene& scene, const Parameter& parameter, double value);

}  // namespace gelenk
