// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/pack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

#include "fmu/export/file_name.h"
#include "fmu/export/picture.h"
#include "fmu/export/write_file.h"
#include "fmu/export/write_page.h"
#include "fmu/export/zip.h"
#include "mechanism/wanted_part.h"
#include "modelDescription/catalog.h"
#include "modelDescription/dependencies.h"
#include "modelDescription/fingerprint.h"
#include "modelDescription/write_xml.h"
#include "scene_file/read.h"
#include "simulation/model_exchange.h"
#include "simulation/simulation.h"
#include "simulation/state_derivatives.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path, const std::string& what) {
  std::error_code none;
  if (fs::is_directory(path, none)) throw ExportError(path.string() + ": found a directory, expected " + what);
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw ExportError(path.string() + ": " + what + " could not be read: " + std::strerror(errno));
  return content;
}

// A platform as FMI 2.0 and FMI 3.0 call it. One library for macOS is for both of its processors.
struct PlatformFolders {
  std::string_view platform, ending;
  std::array<std::string_view, 2> of_fmi3;
};
constexpr std::array<PlatformFolders, 4> platforms{{{"linux64", ".so", {"x86_64-linux"}},
                                                    {"aarch64-linux", ".so", {"aarch64-linux"}},
                                                    {"win64", ".dll", {"x86_64-windows"}},
                                                    {"darwin64", ".dylib", {"x86_64-darwin", "aarch64-darwin"}}}};

struct Binary {
  fs::path file;
  bool gzip;
  std::vector<std::string> folders;
  std::string ending, content;
};

std::vector<std::string> folders_of(const PlatformFolders& platform, FmiVersion version) {
  if (version == FmiVersion::fmi2) return {std::string(platform.platform)};
  std::vector<std::string> out(platform.of_fmi3.begin(), platform.of_fmi3.end());
  std::erase(out, "");
  return out;
}

Binary binary_of(const Runtime& runtime, FmiVersion version) {
  const auto known = std::ranges::find(platforms, runtime.platform, &PlatformFolders::platform);
  if (known == platforms.end()) {
    throw ExportError("platform: found '" + runtime.platform + "', expected linux64, aarch64-linux, win64 or darwin64");
  }
  const bool gzip = runtime.file.extension() == ".gz";
  const std::string ending = (gzip ? runtime.file.stem() : runtime.file).extension().string();
  if (ending != known->ending) {
    throw ExportError(runtime.file.string() + ": the FMU runtime for " + runtime.platform + ": found the extension '" +
                      ending + "', expected " + std::string(known->ending) + ", followed by .gz if it is compressed");
  }
  return {runtime.file, gzip, folders_of(*known, version), ending, read_file(runtime.file, "the FMU runtime")};
}

void add_binary(Zip& zip, const Binary& binary, const std::string& model_identifier) {
  for (const std::string& folder : binary.folders) {
    const std::string name = "binaries/" + folder + "/" + model_identifier + binary.ending;
    if (!binary.gzip) {
      zip.add(name, binary.content, true);
    } else if (!zip.add_gzip(name, binary.content, true)) {
      throw ExportError(
          binary.file.string() +
          ": the FMU runtime: found a file that is not in plain gzip format, expected gzip because of its name");
    }
  }
}

// Names of the files in a directory, sorted because directory order differs between machines. Subdirectories are
// skipped: they contain the licenses of software that is not in every FMU.
std::vector<fs::path> files_in(const fs::path& directory) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::directory_iterator entry(directory, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    if (entry->is_regular_file()) files.push_back(entry->path().filename());
  }
  if (error) throw ExportError(directory.string() + ": directory of licenses could not be read: " + error.message());
  std::ranges::sort(files);
  return files;
}

// A license that several directories contain is added once.
void add_licenses(Zip& zip, const std::vector<fs::path>& directories) {
  std::set<fs::path> added;
  for (const fs::path& directory : directories) {
    for (const fs::path& file : files_in(directory)) {
      if (!added.insert(file).second) continue;
      zip.add("documentation/licenses/" + file.generic_string(), read_file(directory / file, "a license"));
    }
  }
}

std::vector<fs::path> directories_of_licenses(const fs::path& common, const std::vector<Runtime>& runtimes) {
  std::vector<fs::path> found;
  std::error_code none;
  if (!common.empty()) found.push_back(common);
  for (const Runtime& runtime : runtimes) {
    const fs::path own = runtime.file.parent_path() / "licenses";
    if (fs::is_directory(own, none)) found.push_back(own);
  }
  return found;
}

std::vector<double> poses_of_bodies(Simulation& simulation) {
  std::vector<double> out;
  for (std::size_t b = 0; b < simulation.scene().bodies.size(); ++b) {
    const Pose3 X_WB = simulation.body_pose(static_cast<int>(b));
    const Eigen::Quaterniond Q(X_WB.R);
    out.insert(out.end(), {X_WB.p.x(), X_WB.p.y(), X_WB.p.z(), Q.x(), Q.y(), Q.z(), Q.w()});
  }
  return out;
}

}  // namespace

void export_fmu(const Scene& scene, const std::vector<Runtime>& runtimes, const fs::path& out, const fs::path& licenses,
                FmiVersion version, const Compress& compress, const WriteView& view) {
  std::vector<Binary> binaries;
  for (const Runtime& runtime : runtimes) binaries.push_back(binary_of(runtime, version));
  const WantedPart part = wanted_part(scene);
  const std::string json = write_scene_json(part.scene);
  const Scene carried = read_scene_json(json, scene.file);  // exactly what the FMU will read
  Catalog catalog(carried);
  Simulation simulation(carried);
  simulation.assemble();
  catalog.declare_states(StateDerivatives(simulation).independent());

  FmuFacts facts{model_identifier(carried.name), fingerprint(json), simulation.size().states()};
  const bool is_fmi2 = version == FmiVersion::fmi2;
  if (ModelExchange::refusal(carried).empty()) facts.event_indicators = ModelExchange::indicators_of(carried);
  const Picture picture = draw(simulation);
  Zip zip(compress);
  const auto describe = is_fmi2 ? write_fmi2_description : write_fmi3_description;
  zip.add("modelDescription.xml", describe(carried, catalog, dependencies_of(simulation, catalog), facts));
  if (compress) zip.add(is_fmi2 ? "model.png" : "terminalsAndIcons/icon.png", write_png(picture, compress));
  if (!is_fmi2)
    zip.add("terminalsAndIcons/terminalsAndIcons.xml", write_terminals(carried, catalog, compress != nullptr));
  for (const Binary& binary : binaries) add_binary(zip, binary, facts.model_identifier);
  zip.add("resources/scene.json", json);
  const std::string page = view ? view(json, poses_of_bodies(simulation)) : std::string();
  zip.add("documentation/index.html",
          write_documentation(simulation, catalog, {picture, !page.empty(), part.report(), version}));
  if (!page.empty()) zip.add("documentation/view.html", page);
  add_licenses(zip, directories_of_licenses(licenses, runtimes));
  try {
    write_file(out, zip.finish());
  } catch (const std::system_error& error) {
    throw ExportError(out.string() + ": the FMU could not be written: " + error.code().message());
  }
}

}  // namespace gelenk
