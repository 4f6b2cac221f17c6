// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/api_call.h"

#include <stdexcept>

namespace gelenk {
namespace {

std::string joined(const SceneError& error) {
  std::string text;
  for (const std::string& line : error.lines()) text += (text.empty() ? "" : "; ") + line;
  return text;
}

Status log_status(Instance& instance, Category category, Status status, const char* function,
                  const std::string& what) noexcept {
  try {
    instance.log().write(category, std::string(function) + ": " + what);
    return status;
  } catch (...) {
    return status;  // no memory for the message, or the master's logger threw
  }
}

}  // namespace

Status report_exception(Instance& instance, const char* function) noexcept {
  try {
    throw;
  } catch (const StepError& error) {
    return log_status(instance, Category::discard, Status::discard, function, error.what());
  } catch (const SceneError& error) {
    return log_status(instance, Category::error, Status::error, function, joined(error));
  } catch (const AssemblyError& error) {
    return log_status(instance, Category::error, Status::error, function, error.what());
  } catch (const UsageError& error) {
    return log_status(instance, Category::error, Status::error, function, error.what());
  } catch (const std::invalid_argument& error) {
    return log_status(instance, Category::error, Status::error, function, error.what());
  } catch (const std::bad_alloc&) {
    return report_out_of_memory(instance, function);
  } catch (const std::exception& error) {
    instance.fail();
    return log_status(instance, Category::error, Status::error, function,
                      std::string("internal error of the FMU: ") + error.what() + "; reset or free the instance");
  } catch (...) {
    instance.fail();
    return log_status(instance, Category::error, Status::error, function,
                      "unknown internal error of the FMU; reset or free the instance");
  }
}

Status report_out_of_memory(Instance& instance, const char* function) noexcept {
  instance.fail();
  return log_status(instance, Category::error, Status::error, function, "out of memory; reset or free the instance");
}

Status refuse(Instance& instance, const char* function, const std::string& why) {
  return log_status(instance, Category::error, Status::error, function, why);
}

Status discard(Instance& instance, const char* function, const std::string& why) {
  return log_status(instance, Category::discard, Status::discard, function, why);
}

void warn(Instance& instance, const char* function, const std::string& what) noexcept {
  log_status(instance, Category::warning, Status::warning, function, what);
}

bool is_of_kind(Instance& instance, const char* function, Plant::Kind kind) noexcept {
  if (instance.kind() == kind) return true;
  const bool exchanges = kind == Plant::Kind::model_exchange;
  log_status(instance, Category::error, Status::error, function,
             exchanges ? "is a function for model exchange; this instance is for co-simulation"
                       : "is a function for co-simulation; this instance is for model exchange");
  return false;
}

bool allowed(Instance& instance, const char* function, unsigned modes) noexcept {
  if ((modes & static_cast<unsigned>(instance.mode())) != 0) return true;
  try {
    std::string where;
    for (unsigned bit = 1; bit <= static_cast<unsigned>(last_mode); bit *= 2) {
      if ((modes & bit) != 0)
        where += (where.empty() ? "" : " or ") + describe(static_cast<Mode>(bit), instance.interface().vocabulary);
    }
    refuse(instance, function,
           "called " + describe(instance.mode(), instance.interface().vocabulary) + ", expected " + where);
  } catch (...) {
    refuse(instance, function, {});
  }
  return false;
}

}  // namespace gelenk
