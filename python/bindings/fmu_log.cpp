// SPDX-License-Identifier: BSD-3-Clause
// The logger that is given to FMUs which Python runs. fmpy has one pointer for the loggers of a whole process, which
// every plant would overwrite and leave behind when it is closed; and Python's functions cannot take the arguments that
// a message of other tools' FMUs comes with.
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

// Collects what an FMU says; from any of its threads.
class FmuLog {
 public:
  void add(int status, std::string sentence) {
    const std::scoped_lock lock(mutex_);
    sentences_.emplace_back(status, std::move(sentence));
  }

  // What was said since the last time: statuses of FMI and sentences, in any encoding.
  std::vector<std::pair<int, nb::bytes>> take() {
    std::vector<std::pair<int, std::string>> taken;
    {
      const std::scoped_lock lock(mutex_);
      taken.swap(sentences_);
    }
    std::vector<std::pair<int, nb::bytes>> out;
    for (const auto& [status, sentence] : taken) out.emplace_back(status, nb::bytes(sentence.data(), sentence.size()));
    return out;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<int, std::string>> sentences_;
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

// fmi2CallbackLogger, with the log as the component's environment. Nothing is thrown into an FMU.
extern "C" {
// NOLINTNEXTLINE(modernize-avoid-variadic-functions): FMI's type
static void gelenk_fmu_logger(void* environment, const char* /*instance*/, int status, const char* /*category*/,
                              const char* message, ...) noexcept {
  if (environment == nullptr || message == nullptr) return;
  std::va_list arguments;
  va_start(arguments, message);
  try {
    static_cast<FmuLog*>(environment)->add(status, formatted(message, arguments));
  } catch (...) {  // no memory: a sentence less
    (void)environment;
  }
  va_end(arguments);
}
}

void gelenk::bind_fmu_log(nb::module_& m) {
  nb::class_<FmuLog>(m, "FmuLog", "Collects what an FMU logs; has to live as long as the FMU's instance.")
      .def(nb::init<>())
      .def("take", &FmuLog::take, "What was logged since the last time: pairs of a status of FMI and bytes.")
      .def_prop_ro(
          "environment", [](FmuLog& log) { return reinterpret_cast<std::uintptr_t>(&log); },
          "For fmi2CallbackFunctions.componentEnvironment.");
  m.attr("fmu_logger") = reinterpret_cast<std::uintptr_t>(&gelenk_fmu_logger);
}
