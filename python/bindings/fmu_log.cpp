// SPDX-License-Identifier: BSD-3-Clause
// The logger for FMUs that run in Python. fmpy has a single pointer for the loggers of a process, which every plant
// would overwrite and leave dangling when it is closed; and Python functions cannot take the variadic arguments that
// FMUs of other tools pass.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "bindings.h"

namespace nb = nanobind;

namespace {

// Collects the log messages of an FMU, from any of its threads.
class FmuLog {
 public:
  void add(int status, std::string message) {
    const std::scoped_lock lock(mutex_);
    messages_.emplace_back(status, std::move(message));
  }

  // Returns the messages since the last call: FMI status and text, in any encoding.
  std::vector<std::pair<int, nb::bytes>> take() {
    std::vector<std::pair<int, std::string>> taken;
    {
      const std::scoped_lock lock(mutex_);
      taken.swap(messages_);
    }
    std::vector<std::pair<int, nb::bytes>> out;
    for (const auto& [status, message] : taken) out.emplace_back(status, nb::bytes(message.data(), message.size()));
    return out;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<int, std::string>> messages_;
};

std::string formatted(const char* format, std::va_list arguments) {
  std::va_list again;
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return length < 0 ? format : text;
}

}  // namespace

// fmi2CallbackLogger, with the log as component environment. No exception is thrown into the FMU.
extern "C" {
// NOLINTNEXTLINE(modernize-avoid-variadic-functions): FMI's type
static void gelenk_fmu_logger(void* environment, const char* /*instance*/, int status, const char* /*category*/,
                              const char* message, ...) noexcept {
  if (environment == nullptr || message == nullptr) return;
  std::va_list arguments;
  va_start(arguments, message);
  try {
    static_cast<FmuLog*>(environment)->add(status, formatted(message, arguments));
  } catch (...) {  // out of memory: the message is lost
    (void)environment;
  }
  va_end(arguments);
}

// fmi3LogMessageCallback: the same for FMI 3.0.
static void gelenk_fmu3_logger(void* environment, int status, const char* /*category*/, const char* message) noexcept {
  if (environment == nullptr || message == nullptr) return;
  try {
    static_cast<FmuLog*>(environment)->add(status, message);
  } catch (...) {  // out of memory: the message is lost
    (void)environment;
  }
}
}

void gelenk::bind_fmu_log(nb::module_& m) {
  nb::class_<FmuLog>(m, "FmuLog", "Collects the log messages of an FMU; must outlive the FMU's instance.")
      .def(nb::init<>())
      .def("take", &FmuLog::take, "Return the messages since the last call: pairs of FMI status and bytes.")
      .def_prop_ro(
          "environment", [](FmuLog& log) { return reinterpret_cast<std::uintptr_t>(&log); },
          "Value of fmi2CallbackFunctions.componentEnvironment, and of fmi3InstanceEnvironment.")
      .def_prop_ro(
          "logger_of_fmi3", [](const FmuLog&) { return reinterpret_cast<std::uintptr_t>(&gelenk_fmu3_logger); },
          "Address of a function of type fmi3LogMessageCallback.")
      .def_prop_ro(
          "logger", [](const FmuLog&) { return reinterpret_cast<std::uintptr_t>(&gelenk_fmu_logger); },
          "Address of the function for fmi2CallbackFunctions.logger.");
}
