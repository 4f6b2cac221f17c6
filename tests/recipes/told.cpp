// SPDX-License-Identifier: BSD-3-Clause
// told SCENE: reads a scene in JSON and prints, as JSON, the scene as it is written back, the schema, its input and
// output signals, and its parameters.
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "scene/settable.h"
#include "scene/signals.h"
#include "scene_file/read.h"
#include "scene_schema/schema.h"

namespace {

nlohmann::json told(const std::vector<gelenk::Signal>& signals) {
  nlohmann::json out = nlohmann::json::object();
  for (const gelenk::Signal& signal : signals) out[signal.name] = {signal.unit, signal.description};
  return out;
}

}  // namespace

int main(int, char** argv) try {
  std::ifstream file(argv[1]);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const gelenk::Scene scene = gelenk::read_scene_json(text, argv[1]);
  nlohmann::json out = {{"scene", nlohmann::json::parse(gelenk::write_scene_json(scene))},
                        {"schema", nlohmann::json::parse(gelenk::scene_schema())},
                        {"inputs", told(gelenk::input_signals(scene))},
                        {"outputs", told(gelenk::output_signals(scene))},
                        {"settable", nlohmann::json::object()}};
  for (const gelenk::SettableNumber& number : gelenk::settable_numbers(scene)) {
    out["settable"][number.variable(scene)] = {number.unit(scene), number.description(scene)};
  }
  std::cout << out << '\n';
  return 0;
} catch (const std::exception& error) {
  std::cout << error.what() << '\n';
  return 1;
}
