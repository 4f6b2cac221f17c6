// SPDX-License-Identifier: BSD-3-Clause
// Which outputs a scene's `outputs` list: by name, or by pattern as in shells: * any text, ? any character, [ab], [a-c]
// and [!ab] one character. A set in brackets at a pattern's end stands for indices, too: tip.r[1-2], *.f[*].
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// Whether the name is the one meant, or is met by the pattern.
bool meets(std::string_view pattern, std::string_view name);

// By output_signals(scene): it is wanted. All are where the scene lists none.
std::vector<bool> wanted_outputs(const Scene& scene);

// What is wrong with a list of outputs for a valid scene, a clause each, "found ..., expected ...", by entry; empty:
// nothing.
std::vector<std::string> faults_of_outputs(const Scene& scene, const std::vector<std::string>& outputs);

}  // namespace gelenk
