// SPDX-License-Identifier: BSD-3-Clause
// The reader of JSON scenes: any bytes give a scene or a SceneError.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "round_trip.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::optional<gelenk::Scene> scene;
  try {
    scene = gelenk::read_scene_json(text, "fuzz.json");
  } catch (const gelenk::SceneError&) {
    return 0;
  }
  gelenk::fuzz::round_trip(*scene);
  return 0;
}
