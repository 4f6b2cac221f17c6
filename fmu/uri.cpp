// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/uri.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>

namespace gelenk {
namespace {

[[noreturn]] void refuse(std::string_view location, const char* why) {
  throw std::invalid_argument("resource location: found '" + std::string(location) + "', " + why);
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string unescaped(std::string_view text, std::string_view location) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hex(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hex(text[i + 2]) : -1;
    if (high < 0 || low < 0 || high + low == 0) refuse(location, "expected two hexadecimal digits after each %");
    out += static_cast<char>(16 * high + low);
    i += 2;
  }
  return out;
}

// Length of "scheme:" at the beginning, 0 if there is none. A single letter is a drive.
std::size_t scheme_length(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon < 2 || !is_letter(text[0])) return 0;
  const auto fits = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.';
  };
  return std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(colon), fits) ? colon + 1 : 0;
}

bool is_file_scheme(std::string_view scheme) {
  static constexpr std::string_view expected = "file:";
  return std::ranges::equal(scheme, expected,
                            [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

// Strings of FMI are UTF-8 on every system.
std::filesystem::path path_of(const std::string& utf8) { return {std::u8string(utf8.begin(), utf8.end())}; }

}  // namespace

std::filesystem::path directory_of_uri(std::string_view location) {
  const std::size_t scheme = scheme_length(location);
  if (scheme == 0) return path_of(std::string(location));
  if (!is_file_scheme(location.substr(0, scheme))) refuse(location, "expected a path or a file: URI");
  std::string_view rest = location.substr(scheme);
  if (rest.starts_with("//") && !rest.starts_with("///")) {
    const std::size_t slash = std::min(rest.find('/', 2), rest.size());
    const std::string_view host = rest.substr(2, slash - 2);
    const bool drive = host.size() == 2 && is_letter(host[0]) && host[1] == ':';  // file://C:/path, as some write
    if (!drive && host != "localhost" && host != "127.0.0.1") refuse(location, "expected a file on this machine");
    rest.remove_prefix(drive ? 2 : slash);
  }
  while (rest.starts_with("//")) rest.remove_prefix(1);
  std::string path = unescaped(rest, location);
  if (path.size() >= 3 && path[0] == '/' && is_letter(path[1]) && path[2] == ':') path.erase(0, 1);
  return path_of(path);
}

}  // namespace gelenk
