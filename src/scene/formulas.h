// SPDX-License-Identifier: BSD-3-Clause
// The expressions of a scene, and the names of which they are made.
#pragma once

#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// What expressions may name besides the variables of their element.
FormulaNames formula_names(const Scene& scene);

// Reads the expressions again after constants have changed.
void renew_formulas(Scene& scene);

// SI values of the units of the signals that a formula names, in the unit system of the scene.
std::vector<double> signal_sizes(const Scene& scene, const Formula& formula);

// The index of each signal that a formula names among those of a simulation: `first` is that of the scene's first
// input of no element, and `clock` that of the time.
std::vector<int> signal_indices(const Scene& scene, const Formula& formula, int first, int clock);

// The elements of which expressions name this signal, in the order of the file; forces along a joint as this joint.
std::vector<ElementPlace> readers_of(const Scene& scene, std::string_view signal);
// Whether an expression names the time, other than that of a prescribed motion.
inline bool reads_time(const Scene& scene) { return !readers_of(scene, time_signal).empty(); }

}  // namespace gelenk
