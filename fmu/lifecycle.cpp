// SPDX-License-Identifier: BSD-3-Clause
// Creation and deletion of instances, and changes of their mode.
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>

#include "fmu/api_call.h"
#include "fmu/uri.h"

namespace gelenk {
namespace {

// The path as UTF-8, on every system.
std::string text_of(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

struct Closing {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closing>;

// Opens a file such that processes started by the host do not inherit its handle.
File open_to_read(const std::filesystem::path& path) {
#ifdef _WIN32
  return File(_wfopen(path.c_str(), L"rbN"));
#else
  return File(std::fopen(path.c_str(), "rbe"));
#endif
}

std::string read_file(const std::filesystem::path& path) {
  errno = 0;
  std::string content;
  if (const File file = open_to_read(path)) {
    std::array<char, 4096> part{};
    std::size_t n = 0;
    while ((n = std::fread(part.data(), 1, part.size(), file.get())) > 0) content.append(part.data(), n);
    if (std::ferror(file.get()) == 0) return content;
  }
  throw UsageError("the scene " + text_of(path) +
                   " could not be read: " + (errno != 0 ? std::strerror(errno) : "not a file"));
}

std::shared_ptr<const PlantModel> load(const char* location, const std::string& guid) {
  if (location == nullptr)
    throw UsageError("resource location: found a null pointer, expected the FMU's resources directory");
  const std::filesystem::path path = directory_of_uri(location) / "scene.json";
  const std::string json = read_file(path);
  auto model = std::make_shared<const PlantModel>(json, text_of(path));
  if (guid != model->guid) {
    throw UsageError("GUID: found '" + guid + "', expected '" + model->guid +
                     "'; modelDescription.xml, resources/scene.json and the binary are not from the same export");
  }
  return model;
}

std::string refusal(fmi2Type type, const char* guid) {
  if (const int number = number_of(type); number != fmi2CoSimulation && number != fmi2ModelExchange) {
    return "type: found " + std::to_string(number) + ", expected fmi2ModelExchange (0) or fmi2CoSimulation (1)";
  }
  if (guid == nullptr) return "GUID: found a null pointer, expected the one in modelDescription.xml";
  return {};
}

void refuse_exchange(const PlantModel& model) {
  if (const std::string why = ModelExchange::refusal(model.scene); !why.empty())
    throw UsageError("type: found model exchange, expected co-simulation: " + why);
}

fmi2Component instantiate(const Log& log, fmi2Type type, const char* guid, const char* location) {
  std::string why;
  try {
    if (log.instance_name().empty()) throw UsageError("instance name: found none, expected a nonempty string");
    why = refusal(type, guid);
    if (why.empty()) {
      const MemoryReserve memory;
      const bool exchanges = number_of(type) == fmi2ModelExchange;
      const std::shared_ptr<const PlantModel> model = load(location, guid);
      if (exchanges) refuse_exchange(*model);
      auto instance =
          std::make_unique<Instance>(model, log, exchanges ? Plant::Kind::model_exchange : Plant::Kind::co_simulation);
      if (!memory.was_used()) return instance.release();
      why = "out of memory";
    }
  } catch (const SceneError& error) {
    for (const std::string& line : error.lines()) why += (why.empty() ? "" : "; ") + line;
  } catch (const std::exception& error) {
    why = error.what();
  }
  log.write(Category::error, "fmi2Instantiate: " + why);
  return nullptr;
}

}  // namespace
}  // namespace gelenk

using gelenk::Instance;
using gelenk::Mode;

extern "C" {

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }

const char* fmi2GetVersion() { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions* functions,
                              fmi2Boolean /*visible*/, fmi2Boolean loggingOn) {
  const gelenk::FloatingPointGuard floating_point;
  try {
    return gelenk::instantiate(
        gelenk::Log(functions, instanceName != nullptr ? instanceName : "", loggingOn != fmi2False), fmuType, fmuGUID,
        fmuResourceLocation);
  } catch (...) {  // no memory even for a message
    return nullptr;
  }
}

void fmi2FreeInstance(fmi2Component c) { delete static_cast<Instance*>(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  return gelenk::call(c, "fmi2SetDebugLogging", gelenk::any_mode, [&](Instance& instance) {
    if (nCategories > 0 && categories == nullptr) {
      return gelenk::refuse(instance, "fmi2SetDebugLogging",
                            "categories: found a null pointer, expected an array of " + std::to_string(nCategories));
    }
    const char* unknown = instance.log().select(loggingOn != fmi2False, nCategories, categories);
    if (unknown == nullptr) return fmi2OK;
    std::string known(gelenk::log_all);
    for (const auto& category : gelenk::log_categories) known += std::string(", ") + category.name;
    return gelenk::refuse(instance, "fmi2SetDebugLogging",
                          std::string("category: found '") + unknown + "', expected one of " + known);
  });
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
  return gelenk::call(c, "fmi2SetupExperiment", 0U | Mode::instantiated, [&](Instance& instance) {
    const auto given = [](fmi2Boolean defined, double value) {
      return defined != fmi2False ? std::optional(value) : std::nullopt;
    };
    instance.setup_experiment(given(toleranceDefined, tolerance), startTime, given(stopTimeDefined, stopTime));
    return fmi2OK;
  });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return gelenk::call(c, "fmi2EnterInitializationMode", 0U | Mode::instantiated, [](Instance& instance) {
    instance.enter_initialization();
    return fmi2OK;
  });
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return gelenk::call(c, "fmi2ExitInitializationMode", 0U | Mode::initialization, [](Instance& instance) {
    instance.exit_initialization();
    return fmi2OK;
  });
}

fmi2Status fmi2Terminate(fmi2Component c) {
  return gelenk::call(c, "fmi2Terminate", gelenk::running, [](Instance& instance) {
    instance.terminate();
    return fmi2OK;
  });
}

fmi2Status fmi2Reset(fmi2Component c) {
  return gelenk::call(c, "fmi2Reset", gelenk::any_mode, [](Instance& instance) {
    instance.reset();
    return fmi2OK;
  });
}

}  // extern "C"
