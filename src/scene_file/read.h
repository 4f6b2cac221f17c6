// SPDX-License-Identifier: BSD-3-Clause
// Scene files: reading and writing. JSON is what the FMU carries; YAML is for people.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

inline constexpr int scene_version = 1;  // `gelenk: 1`

// Of a scene's text: 32 MB, some 80 000 bodies. Reading takes twenty times as much memory, and nothing tells beforehand
// that a larger file is a scene at all.
inline constexpr std::size_t most_bytes = 32'000'000;
// Throws SceneError where there are more.
void check_size(std::size_t bytes, const std::string& file);

// Reads and checks a scene. file is only used in messages. Throws SceneError with every fault found.
Scene read_scene_json(std::string_view text, const std::string& file);

// As read_scene_json; what is doubtful is added to doubts, "file: path: found ..., expected ...; what to do".
Scene read_scene_json(std::string_view text, const std::string& file, std::vector<std::string>& doubts);
#ifdef GELENK_WITH_YAML
// Likewise, from YAML 1.2 (core schema).
Scene read_scene_yaml(std::string_view text, const std::string& file);
Scene read_scene_yaml(std::string_view text, const std::string& file, std::vector<std::string>& doubts);
#endif

// The scene as JSON that read_scene_json reads back to the same bits: all frames in bodies, no `at:`.
// The scene must be valid.
std::string write_scene_json(const Scene& scene);

// The scene with quaternions made unit again and everything checked that only several values together can break
// (moments of inertia). Throws SceneError.
Scene checked(const Scene& scene);

// JSON Schema (draft 2020-12) of scene files, made from the joint registry.
std::string scene_schema();

}  // namespace gelenk
