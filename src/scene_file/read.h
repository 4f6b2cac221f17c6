// SPDX-License-Identifier: BSD-3-Clause
// Reading and writing scene files. FMUs contain JSON; YAML is the format for people.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

inline constexpr int scene_version = 1;  // `gelenk: 1`

// Largest size of a scene's text: 32 MB, about 80 000 bodies. Reading takes twenty times as much memory, and a larger
// file is probably not a scene.
inline constexpr std::size_t max_scene_bytes = 32'000'000;
// Throws SceneError if a file has more bytes than that.
void check_size(std::size_t bytes, const std::string& file);

// Reads and checks a scene. `file` is only used in messages. Throws SceneError with all errors found.
Scene read_scene_json(std::string_view text, const std::string& file);

// The same; warnings "file: path: found ..., expected ...; what to do" are appended to `warnings`.
Scene read_scene_json(std::string_view text, const std::string& file, std::vector<std::string>& warnings);
#ifdef GELENK_WITH_YAML
// The same for YAML 1.2 (core schema).
Scene read_scene_yaml(std::string_view text, const std::string& file);
Scene read_scene_yaml(std::string_view text, const std::string& file, std::vector<std::string>& warnings);
#endif

// Returns a valid scene as JSON that read_scene_json reads back with bitwise identical numbers; all frames are given in
// bodies, none by `at:`.
std::string write_scene_json(const Scene& scene);

// Returns the scene with normalized quaternions and all checks repeated, including those of several values in
// combination (moments of inertia), after numbers were changed. Throws SceneError.
Scene checked(const Scene& scene);

}  // namespace gelenk
