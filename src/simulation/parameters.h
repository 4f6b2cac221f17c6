// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a scene that may still be set before a simulation starts: one table for the FMU's
// parameters and Python's `--set` alike.
//
// Always there: start values of joints, gravity, solver settings. Of the rest those that the scene lists under
// `parameters`, by the path in the file ("crank.mass", "A.damping"; an array is listed as a whole: "crank.com").
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
  std::string unit;         // FMI spelling; empty for what has none
  std::string description;  // one sentence
  ParameterType type = ParameterType::real;
  std::vector<std::string> items;  // of an enumeration, in the order of its values 1, 2, ...
  std::vector<std::string> item_summaries;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool tunable = false;  // may change during a run (Simulation::tune)

  // Booleans are 0 or 1, enumerations the item's number from 1. Use set_parameter() to set.
  std::function<double(const Scene&)> get;
  std::function<void(Scene&, double)> put;
};

// In this order: joint starts (joints in file order), gravity, solver, those listed in scene.parameters.
// The functions in the table fit every scene with the same bodies, joints, motors and forces.
// Throws SceneError for a listed path that names nothing settable.
std::vector<Parameter> scene_parameters(const Scene& scene);

// Throws std::invalid_argument, naming the parameter, the value found and what is allowed.
void check_parameter(const Parameter& parameter, double value);

// Throws what check_parameter() throws; the scene is then unchanged. Setting the present value changes nothing at
// all (a guess stays a guess).
void set_parameter(Scene& scene, const Parameter& parameter, double value);

}  // namespace gelenk
