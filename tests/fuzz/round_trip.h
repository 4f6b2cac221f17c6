// SPDX-License-Identifier: BSD-3-Clause
// What must hold of a scene, whatever bytes it came from.
#pragma once

#include <cstdlib>
#include <iostream>
#include <string>

#include "scene_file/read.h"

namespace gelenk::fuzz {

// Written and read back it is the same: its second text is its first. Ends the process where it is not.
inline void round_trip(const Scene& scene) {
  const std::string first = write_scene_json(scene);
  try {
    const std::string second = write_scene_json(read_scene_json(first, "first.json"));
    if (first == second) return;
    std::cerr << "written, read and written again:\n" << first << "\n---\n" << second << '\n';
  } catch (const SceneError& error) {
    std::cerr << "what was written is refused: " << error.what() << '\n' << first << '\n';
  }
  std::abort();
}

}  // namespace gelenk::fuzz
