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

// Binds the signals that a formula names to their indices in a simulation, where the first input of no element has the
// index first_input, and the time follows the last one.
void bind_signals(Formula& formula, const Scene& scene, int first_input);

// The elements of which expressions name this signal, in the order of the file; forces along a joint as this joint.
std::vector<ElementPlace> readers_of(const Scene& scene, std::string_view signal);
// Whether an expression names the time, other than that of a prescribed motion.
inline bool reads_time(const Scene& scene) { return !readers_of(scene, time_signal).empty(); }

}  // namespace gelenk
