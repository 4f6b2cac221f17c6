// SPDX-License-Identifier: BSD-3-Clause
// A scene of which some parameters may vary: its equations, recorded with variables for the numbers that depend on
// them, and these numbers for any values.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batch/numbers.h"
#include "equations/scene_equations.h"
#include "scene/scene.h"
#include "simulation/parameters.h"

namespace gelenk {

// Of a lane: the numbers that vary, the state, and accelerations by the general kernels at other velocities, which
// the constraints permit. size: that these could have.
struct LaneStart {
  std::vector<double> numbers, state, v, vdot;
  double size = 0;
};

class VariedScene {
 public:
  // Throws SceneError with the names of elements that lanes cannot do without events, and UsageError for a parameter
  // that cannot vary.
  VariedScene(const Scene& scene, const std::vector<std::string>& parameters);

  const SceneEquations& equations() const { return recorded_->equations(); }
  // With the values of the scene.
  const TracedScene& traced() const { return *recorded_; }
  // Variables of the equations from VariedNumbers::first_variable on.
  int numbers() const { return varied_->count(); }
  // The values of the parameters in the scene.
  std::vector<double> values() const;
  // prefix: of messages. Throws SceneError, AssemblyError, UsageError.
  LaneStart start(const std::vector<double>& values, const std::string& prefix) const;

 private:
  Scene with(const std::vector<double>& values) const;
  enum class Replaced { all, numbers_of_elements };
  Scene without_special_values(const std::vector<double>& values, Replaced which) const;
  NumberedScene changed() const;
  bool record(const Scene& scene, const NumberedScene& first, const NumberedScene& changed);
  bool find(const NumberedScene& scene, const TracedScene& wanted, std::vector<double>& out) const;
  SceneError other_equations(const std::vector<double>* values) const;

  Scene scene_;
  std::vector<Parameter> parameters_;
  std::unique_ptr<VariedNumbers> varied_;
  std::unique_ptr<TracedScene> recorded_;
};

}  // namespace gelenk
