// SPDX-License-Identifier: BSD-3-Clause
// Log messages of an instance to its master.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "fmi2Functions.h"
#include "modelDescription/capabilities.h"

namespace gelenk {

class Log {
 public:
  // callbacks may be null, and so may its logger: then nothing is logged.
  Log(const fmi2CallbackFunctions* callbacks, std::string instance_name, bool events);

  // The name given at instantiation.
  const std::string& instance_name() const { return name_; }

  // Switches all categories on or off or, with names, those on and the others off. Returns null or, without any change,
  // the first unknown name.
  const char* select(bool on, std::size_t count, const fmi2String names[]);

  bool is_enabled(Category category) const { return logger_ != nullptr && on_[static_cast<std::size_t>(category)]; }
  // Throws std::bad_alloc.
  void write(Category category, std::string_view message) const;

 private:
  static constexpr std::size_t n = log_categories.size();
  std::string name_;
  fmi2CallbackLogger logger_ = nullptr;
  fmi2ComponentEnvironment environment_ = nullptr;
  std::array<bool, n> on_{};
};

// The text as a printf format: % is doubled, since loggers interpret messages as formats, control characters become
// spaces, and bytes that are not UTF-8 (of a damaged file) question marks.
std::string as_format(std::string_view text);

}  // namespace gelenk
