// SPDX-License-Identifier: BSD-3-Clause
// The expressions of a scene, and the names of which they are made.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "scene/scene.h"
#include "scene/signals.h"

namespace gelenk {

// What expressions may name besides the variables of their element.
FormulaNames formula_names(const Scene& scene);

// Reads the expressions again after constants have changed.
void renew_formulas(Scene& scene);

// The names of the coordinates of a joint that expressions may use, and of their rates.
void add_coordinate_names(std::string_view joint, const JointKind& kind, std::unordered_set<std::string>& out);
// A coordinate of a joint, or one of its velocities.
struct JointQuantity {
  int joint = -1, component = 0;
  bool is_rate = false;
  std::string_view unit;
};
// The one with this name, such as "A.phi".
std::optional<JointQuantity> find_coordinate(const Scene& scene, std::string_view name);

// The same for outputs of a sensor that depend on positions and velocities alone.
void add_sensor_names(std::string_view sensor, const ElementKind& kind, std::unordered_set<std::string>& out);
struct SensorOutput {
  int sensor = -1, group = 0, component = 0;
};
std::optional<SensorOutput> find_sensor_output(const Scene& scene, std::string_view name);

// The outputs that expressions of outputs and rates of states may name besides: forces and accelerations. Those of
// contacts between shapes and of the whole mechanism are not among them.
std::vector<Signal> force_signals(const Scene& scene);
std::shared_ptr<const std::unordered_set<std::string>> force_names(const Scene& scene);

// Whether it names element states or anything of the motion, not only inputs and the time.
bool couples(const Scene& scene, const Formula& formula);

// An element with an expression, forces along a joint as this joint, and the signals that it names.
struct FormulaReader {
  ElementPlace place;
  std::vector<std::string> signals;
};
// All that name any, in the order of the file; first the element states and the named expressions, by their name.
std::vector<FormulaReader> formula_readers(const Scene& scene);

// The first element state that has resets; null: none.
const ElementState* first_with_resets(const Scene& scene);
// The first element state whose rate names forces or accelerations; null: none.
const ElementState* first_with_rate_of_forces(const Scene& scene);

// The elements of which expressions name this signal, in the order of the file; forces along a joint as this joint.
std::vector<ElementPlace> readers_of(const Scene& scene, std::string_view signal);
// Whether an expression names the time, other than that of a prescribed motion.
bool reads_time(const Scene& scene);
// The joints and sensors of which expressions name coordinates, rates or outputs.
std::unordered_set<std::string> named_of_motion(const Scene& scene);
// SI value of the natural unit of an element state.
double size_of(const ElementState& state, const UnitSystem& units);

}  // namespace gelenk
