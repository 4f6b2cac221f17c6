// SPDX-License-Identifier: BSD-3-Clause
// What an instance says to its master: one finished sentence at a time.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "fmi2Functions.h"
#include "modelDescription/capabilities.h"

namespace gelenk {

class Log {
 public:
  // callbacks may be null, and so may its logger: then nothing is said.
  Log(const fmi2CallbackFunctions* callbacks, std::string instance_name, bool events);

  // The name given at instantiation.
  const std::string& instance_name() const { return name_; }

  // All categories on or off, or those named on and the others off. Returns the first name that is unknown, else
  // null; nothing is changed then.
  const char* select(bool on, std::size_t count, const fmi2String names[]);

  bool listens(Category category) const { return logger_ != nullptr && on_[static_cast<std::size_t>(category)]; }
  // Throws std::bad_alloc.
  void say(Category category, std::string_view sentence) const;

 private:
  static constexpr std::size_t n = log_categories.size();
  std::string name_;
  fmi2CallbackLogger logger_ = nullptr;
  fmi2ComponentEnvironment environment_ = nullptr;
  std::array<bool, n> on_{};
};

// The text as printf prints it back, each % doubled, since loggers take the message for a format; on one line, and in
// UTF-8, as strings of FMI are: other bytes (of a damaged file) become question marks.
std::string as_format(std::string_view text);

}  // namespace gelenk
