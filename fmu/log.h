// SPDX-License-Identifier: BSD-3-Clause
// Log messages of an instance to its master.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>

#include "fmu/status.h"
#include "modelDescription/capabilities.h"

namespace gelenk {

class Log {
 public:
  // Passes a text to the master's logger.
  using Pass = std::function<void(const char* instance, Status, const char* category, const std::string& text)>;

  // pass: may be empty; then nothing is logged.
  Log(Pass pass, std::string instance_name, bool events);

  // The name given at instantiation.
  const std::string& instance_name() const { return name_; }

  // Switches all categories on or off or, with names, those on and the others off. Returns null or, without any change,
  // the first unknown name.
  const char* select(bool on, std::size_t count, const char* const names[]);

  bool is_enabled(Category category) const { return pass_ && on_[static_cast<std::size_t>(category)]; }
  // Throws std::bad_alloc.
  void write(Category category, std::string_view message) const;

 private:
  static constexpr std::size_t n = log_categories.size();
  std::string name_;
  Pass pass_;
  std::array<bool, n> on_{};
};

// The text without control characters, which become spaces, and bytes that are not UTF-8 (of a damaged file), which
// become question marks.
std::string as_printable(std::string_view text);

}  // namespace gelenk
