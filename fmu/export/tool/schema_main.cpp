// SPDX-License-Identifier: BSD-3-Clause
// gelenk-schema FILE: writes the JSON Schema of scene files. Used by the build, not by users.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "scene_schema/schema.h"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: gelenk-schema FILE\n";
    return 2;
  }
  const std::filesystem::path path = argv[1];
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path);
  file << gelenk::scene_schema() << '\n';
  file.close();
  if (!file) {
    std::cerr << "gelenk-schema: cannot write " << path << '\n';
    return 1;
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "gelenk-schema: " << error.what() << '\n';
  return 1;
}
