// SPDX-License-Identifier: BSD-3-Clause
// gelenk-export SCENE OUT.fmu --runtime PLATFORM=FILE... [--licenses DIR] [--fmi 2|3]: export without Python, for
// CMake.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#ifdef GELENK_WITH_ZLIB
#include <zlib.h>

#include <new>
#endif

#include "check/warnings.h"
#include "fmu/export/pack.h"
#include "scene_file/read.h"

namespace {

constexpr const char* usage =
    "usage: gelenk-export SCENE OUT.fmu --runtime PLATFORM=FILE... [--licenses DIR] [--fmi 2|3]\n"
    "  SCENE    scene file, JSON"
#ifdef GELENK_WITH_YAML
    " or YAML"
#endif
    "\n"
    "  OUT.fmu  the FMU to write\n"
    "  PLATFORM linux64, aarch64-linux, win64 or darwin64\n"
    "  FILE     the FMU runtime library of Gelenk for that platform, or its .gz file\n"
    "  DIR      directory with the licenses to include\n"
    "  2, 3     version of FMI: 2.0 (default) or 3.0\n";

struct Options {
  std::vector<std::string> files;
  std::vector<gelenk::Runtime> runtimes;
  std::string licenses;
  gelenk::FmiVersion version = gelenk::FmiVersion::fmi2;
};

bool parse_runtime(std::string_view word, Options& options) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos) return false;
  options.runtimes.push_back({std::string(word.substr(0, equals)), word.substr(equals + 1)});
  return true;
}

bool parse_version(std::string_view word, Options& options) {
  if (word != "2" && word != "3") return false;
  options.version = word == "2" ? gelenk::FmiVersion::fmi2 : gelenk::FmiVersion::fmi3;
  return true;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--runtime" || word == "--licenses" || word == "--fmi") {
      if (++i == argc) return false;
      if (word == "--runtime" && !parse_runtime(argv[i], options)) return false;
      if (word == "--licenses") options.licenses = argv[i];
      if (word == "--fmi" && !parse_version(argv[i], options)) return false;
    } else if (word.starts_with("--")) {
      return false;
    } else {
      options.files.emplace_back(word);
    }
  }
  return options.files.size() == 2 && !options.runtimes.empty();
}

gelenk::Scene read_scene(const std::string& path, std::vector<std::string>& doubts) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw gelenk::ExportError(path + ": the scene could not be read");
#ifdef GELENK_WITH_YAML
  if (path.ends_with(".yaml") || path.ends_with(".yml")) return gelenk::read_scene_yaml(text, path, doubts);
#endif
  return gelenk::read_scene_json(text, path, doubts);
}

#ifdef GELENK_WITH_ZLIB
std::string zlib_stream(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  const auto* from = reinterpret_cast<const Bytef*>(bytes.data());
  if (compress(reinterpret_cast<Bytef*>(out.data()), &size, from, static_cast<uLong>(bytes.size())) != Z_OK) {
    throw std::bad_alloc();
  }
  out.resize(size);
  return out;
}
#else
const gelenk::Compress zlib_stream;
#endif

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) {
    std::cerr << usage;
    return 2;
  }
  try {
    std::vector<std::string> doubts;
    const gelenk::Scene scene = read_scene(options.files[0], doubts);
    for (const std::string& doubt : doubts) std::cerr << doubt << '\n';
    gelenk::export_fmu(scene, options.runtimes, options.files[1], options.licenses, options.version, zlib_stream, {});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
