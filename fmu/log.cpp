// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/log.h"

#include <cstring>
#include <utility>

namespace gelenk {
namespace {

Status status_of(Category category) {
  switch (category) {
    case Category::events:
      break;
    case Category::warning:
      return Status::warning;
    case Category::discard:
      return Status::discard;
    case Category::error:
      return Status::error;
  }
  return Status::ok;
}

// Length in bytes of the UTF-8 character at the beginning of a nonempty text; 0: not UTF-8.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  return length;
}

}  // namespace

Log::Log(Pass pass, std::string instance_name, bool events) : name_(std::move(instance_name)), pass_(std::move(pass)) {
  on_.fill(true);
  on_[static_cast<std::size_t>(Category::events)] = events;
}

const char* Log::select(bool on, std::size_t count, const char* const names[]) {
  std::array<bool, n> chosen{};
  if (on && count == 0) chosen.fill(true);
  for (std::size_t i = 0; i < count; ++i) {
    const bool all = names[i] != nullptr && log_all == names[i];
    bool known = all;
    for (std::size_t c = 0; c < n; ++c) {
      if (!all && (names[i] == nullptr || std::strcmp(names[i], log_categories[c].name) != 0)) continue;
      known = true;
      chosen[c] = on;
    }
    if (!known) return names[i] == nullptr ? "a null pointer" : names[i];
  }
  on_ = chosen;
  return nullptr;
}

void Log::write(Category category, std::string_view message) const {
  const auto c = static_cast<std::size_t>(category);
  if (!pass_ || !on_[c]) return;
  pass_(name_.c_str(), status_of(category), log_categories[c].name, as_printable(message));
}

std::string as_printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text.substr(i));
    if (length == 0 || static_cast<unsigned char>(text[i]) < ' ') {
      out += length == 0 ? '?' : ' ';
      ++i;
      continue;
    }
    out += text.substr(i, length);
    i += length;
  }
  return out;
}

}  // namespace gelenk
