// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/lifecycle.h"

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

std::shared_ptr<const PlantModel> load_model(const Instantiation& wanted) {
  const Vocabulary& words = wanted.interface.vocabulary;
  if (wanted.token == nullptr) {
    throw UsageError(std::string(words.token) + ": found a null pointer, expected the one in modelDescription.xml");
  }
  if (wanted.resources == nullptr) {
    throw UsageError(std::string(words.resources) + ": found a null pointer, expected the FMU's resources directory");
  }
  const std::filesystem::path path = directory_of_uri(wanted.resources) / "scene.json";
  const std::string json = read_file(path);
  auto model = std::make_shared<const PlantModel>(json, text_of(path));
  if (wanted.token != model->guid) {
    throw UsageError(std::string(words.token) + ": found '" + wanted.token + "', expected '" + model->guid +
                     "'; modelDescription.xml, resources/scene.json and the binary are not from the same export");
  }
  return model;
}

void refuse_exchange(const PlantModel& model, const Instantiation& wanted) {
  const std::string why = ModelExchange::refusal(model.scene);
  if (!why.empty()) throw UsageError(wanted.interface.vocabulary.no_exchange + why);
}

std::unique_ptr<Instance> created(const Log& log, const Instantiation& wanted) {
  if (log.instance_name().empty()) throw UsageError("instance name: found none, expected a nonempty string");
  if (!wanted.fault.empty()) throw UsageError(wanted.fault);
  const MemoryReserve memory;
  const std::shared_ptr<const PlantModel> model = load_model(wanted);
  if (wanted.kind == Plant::Kind::model_exchange) refuse_exchange(*model, wanted);
  auto instance = std::make_unique<Instance>(model, log, wanted.kind, wanted.interface);
  if (memory.was_used()) throw UsageError("out of memory");
  return instance;
}

void* created_or_null(const Log& log, const Instantiation& wanted) {
  std::string why;
  try {
    return created(log, wanted).release();
  } catch (const SceneError& error) {
    for (const std::string& line : error.lines()) why += (why.empty() ? "" : "; ") + line;
  } catch (const std::exception& error) {
    why = error.what();
  }
  log.write(Category::error, std::string(wanted.function) + ": " + why);
  return nullptr;
}

// Runs change(instance).
template <class Change>
Status change_mode(void* c, const char* function, unsigned modes, Change&& change) noexcept {
  return call(c, function, modes, [&](Instance& instance) {
    std::forward<Change>(change)(instance);
    return Status::ok;
  });
}

void set_up(Instance& instance, const ExperimentSetup& experiment) {
  instance.setup_experiment(experiment.tolerance, experiment.start, experiment.stop);
}

}  // namespace

void* instantiate(const Log& log, const Instantiation& wanted) noexcept {
  const FloatingPointGuard floating_point;
  try {
    return created_or_null(log, wanted);
  } catch (...) {  // no memory even for a message
    return nullptr;
  }
}

void free_instance(void* instance) noexcept { delete static_cast<Instance*>(instance); }

Status set_debug_logging(void* instance, const char* function, bool on, std::size_t count,
                         const char* const categories[]) noexcept {
  return call(instance, function, any_mode, [&](Instance& of) {
    if (count > 0 && categories == nullptr) {
      return refuse(of, function, "categories: found a null pointer, expected an array of " + std::to_string(count));
    }
    const char* unknown = of.log().select(on, count, categories);
    if (unknown == nullptr) return Status::ok;
    std::string known(log_all);
    for (const auto& category : log_categories) known += std::string(", ") + category.name;
    return refuse(of, function, std::string("category: found '") + unknown + "', expected one of " + known);
  });
}

Status setup_experiment(void* instance, const char* function, const ExperimentSetup& experiment) noexcept {
  return change_mode(instance, function, 0U | Mode::instantiated, [&](Instance& of) { set_up(of, experiment); });
}

Status enter_initialization(void* instance, const char* function, const ExperimentSetup* experiment) noexcept {
  return change_mode(instance, function, 0U | Mode::instantiated, [&](Instance& of) {
    if (experiment != nullptr) set_up(of, *experiment);
    of.enter_initialization();
  });
}

Status exit_initialization(void* instance, const char* function) noexcept {
  return change_mode(instance, function, 0U | Mode::initialization, [](Instance& of) { of.exit_initialization(); });
}

Status terminate(void* instance, const char* function) noexcept {
  return change_mode(instance, function, running, [](Instance& of) { of.terminate(); });
}

Status reset(void* instance, const char* function) noexcept {
  return change_mode(instance, function, any_mode, [](Instance& of) { of.reset(); });
}

}  // namespace gelenk
