// SPDX-License-Identifier: BSD-3-Clause
// The list `outputs` of a scene selects outputs by name or by shell pattern: * any text, ? any character, [ab], [a-c]
// and
// [!ab] one character. A set in brackets at the end of a pattern also selects indices: tip.r[1-2], *.f[*].
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// Returns true if the name equals the pattern or matches it.
bool output_matches(std::string_view pattern, std::string_view name);

// Returns a flag for each of output_signals(scene): it is selected. All are if the scene has no list.
std::vector<bool> wanted_outputs(const Scene& scene);

// Checks a list of outputs for a valid scene. Returns a clause "found ..., expected ..." for each entry; empty if the
// entry is correct.
std::vector<std::string> faults_of_outputs(const Scene& scene, const std::vector<std::string>& outputs);

}  // namespace gelenk
