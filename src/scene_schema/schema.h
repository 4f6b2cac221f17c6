// SPDX-License-Identifier: BSD-3-Clause
// The JSON Schema of scene files, by which editors check and complete them.
#pragma once

#include <string>

namespace gelenk {

// Returns the JSON Schema (draft 2020-12) of scene files, generated from the registries of joints, elements and shapes.
std::string scene_schema();

}  // namespace gelenk
