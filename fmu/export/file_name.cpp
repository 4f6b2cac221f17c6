// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/file_name.h"

#include <algorithm>
#include <array>

namespace gelenk {
namespace {

constexpr std::size_t max_stem_bytes = 200;  // file systems allow 255, with extension and a temporary suffix

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

// The part that Windows compares with device names: up to the first dot, without trailing spaces.
std::string_view without_extensions(std::string_view name) {
  name = name.substr(0, name.find('.'));
  return name.substr(0, name.find_last_not_of(' ') + 1);
}

// Truncates a text between two UTF-8 characters.
std::string_view truncated(std::string_view text) {
  if (text.size() <= max_stem_bytes) return text;
  std::size_t n = max_stem_bytes;
  while (n > 0 && (static_cast<unsigned char>(text[n]) & 0xc0U) == 0x80U) --n;
  return text.substr(0, n);
}

}  // namespace

bool is_device_name(std::string_view name) {
  std::string device(without_extensions(name));
  std::ranges::transform(device, device.begin(), capital);
  constexpr std::array alone = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"};
  if (std::ranges::find(alone, device) != alone.end()) return true;
  constexpr std::array numbers = {"0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "¹", "²", "³"};
  return (device.starts_with("COM") || device.starts_with("LPT")) &&
         std::ranges::find(numbers, device.substr(3)) != numbers.end();
}

std::string file_stem(std::string_view name) {
  std::string stem(truncated(name));
  constexpr std::string_view forbidden = "<>:\"/\\|?*";
  for (char& c : stem) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f' || forbidden.find(c) != std::string_view::npos) c = '_';
  }
  // Windows drops trailing dots and spaces; names with a leading dot are hidden, with a leading hyphen taken for
  // options.
  for (std::size_t i = stem.size(); i > 0 && (stem[i - 1] == '.' || stem[i - 1] == ' '); --i) stem[i - 1] = '_';
  for (char& c : stem) {
    if (c != '.' && c != ' ' && c != '-') break;
    c = '_';
  }
  if (is_device_name(stem)) stem.insert(without_extensions(stem).size(), "_");
  return stem.empty() ? "_" : stem;
}

std::string model_identifier(std::string_view name) {
  std::string text;
  for (const char c : name) text += is_letter(c) || is_digit(c) ? c : '_';
  if (text.empty() || is_digit(text.front())) text.insert(0, "_");
  return is_device_name(text) ? text + "_" : text;
}

}  // namespace gelenk
