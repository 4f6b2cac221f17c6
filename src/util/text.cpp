// SPDX-License-Identifier: BSD-3-Clause
#include "util/text.h"

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "util/synonyms.h"

namespace gelenk::text {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Edit distance: letters to insert, delete, change or exchange with their neighbor (Damerau 1964); case is ignored.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1])) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

void replace(std::string& text, std::string_view placeholder, std::string_view by) {
  for (std::size_t at = text.find(placeholder); at != std::string::npos; at = text.find(placeholder, at + by.size())) {
    text.replace(at, placeholder.size(), by);
  }
}

namespace {

// As printf, but with a point in any locale of the host. Not to_chars, whose tables take 100 kB of each FMU.
std::string formatted(const char* format, int digits, double x) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, digits, x);
  std::string out = buffer.data();
  const std::string_view point = std::localeconv()->decimal_point;
  if (const std::size_t at = out.find(point); at != std::string::npos) out.replace(at, point.size(), ".");
  return out;
}

// The fewest significant digits that give x again, as d.ddde+xx.
std::string shortest(double x) {
  constexpr int always = 15, enough = 17;  // digits that a number of full precision keeps, and that it needs
  std::array<char, 64> buffer{};
  int digits = std::fpclassify(x) == FP_SUBNORMAL ? 1 : always;
  for (; digits < enough; ++digits) {
    std::snprintf(buffer.data(), buffer.size(), "%.*e", digits - 1, x);
    if (std::strtod(buffer.data(), nullptr) == x) break;
  }
  std::string out = formatted("%.*e", digits - 1, x);
  const std::size_t exponent = out.find('e');
  std::size_t last = exponent;
  if (out.find('.') < exponent) {
    while (out[last - 1] == '0') --last;
    if (out[last - 1] == '.') --last;
  }
  return out.erase(last, exponent - last);
}

}  // namespace

std::string number(double x) {
  if (std::isnan(x)) return "NaN";
  if (std::isinf(x)) return x > 0 ? "Infinity" : "-Infinity";
  std::string scientific = shortest(x);
  const std::size_t e = scientific.find('e');
  const auto exponent = static_cast<int>(std::strtol(scientific.c_str() + e + 1, nullptr, 10));
  const std::string sign = scientific[0] == '-' ? "-" : "";
  std::string digits = scientific.substr(sign.size(), e - sign.size());
  std::erase(digits, '.');
  const auto count = static_cast<int>(digits.size());
  std::string fixed = sign;
  if (exponent < 0) {
    if (exponent < -static_cast<int>(scientific.size())) return scientific;
    fixed += "0." + std::string(static_cast<std::size_t>(-exponent - 1), '0') + digits;
  } else if (exponent >= count - 1) {
    if (exponent - count > static_cast<int>(scientific.size())) return scientific;
    fixed += digits + std::string(static_cast<std::size_t>(exponent - count + 1), '0');
  } else {
    fixed += digits.substr(0, static_cast<std::size_t>(exponent) + 1) + "." +
             digits.substr(static_cast<std::size_t>(exponent) + 1);
  }
  return fixed.size() <= scientific.size() ? fixed : scientific;
}

std::string rounded(double x, int digits) { return formatted("%.*g", digits, x); }

std::string with_unit(const std::string& value, std::string_view unit) {
  return unit.empty() ? value : value + " " + std::string(unit);
}

std::string list(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

std::string some(const std::vector<std::string>& names) {
  constexpr std::size_t max_listed = 8;
  const std::size_t shown = names.size() > max_listed ? max_listed - 2 : names.size();
  std::string out;
  for (std::size_t i = 0; i < shown; ++i) {
    const bool last = i + 1 == names.size();
    out += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  return shown == names.size() ? out : out + " and " + std::to_string(names.size() - shown) + " more";
}

std::string printable(std::string_view raw) {
  constexpr std::size_t max_bytes = 60;
  std::string out;
  std::size_t i = 0;
  for (; i < raw.size() && out.size() < max_bytes; ++i) {
    const auto c = static_cast<unsigned char>(raw[i]);
    if (c >= 0x20 && c != 0x7f) {
      out += raw[i];
    } else {
      std::array<char, 8> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\x%02x", c);
      out += escaped.data();
    }
  }
  // The last UTF-8 character is completed.
  for (; i < raw.size() && (static_cast<unsigned char>(raw[i]) & 0xc0) == 0x80; ++i) out += raw[i];
  return i < raw.size() ? out + "..." : out;
}

std::string quoted(std::string_view raw) { return "'" + printable(raw) + "'"; }

std::string nearest(std::string_view found, const std::vector<std::string>& names) {
  if (found.size() > 60) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, found.size() / 3) + 1;  // at most one error in three letters
  for (const std::string& name : names) {
    if (name.size() > 60) continue;
    const std::size_t d = distance(found, name);
    if (d < best_distance) {
      best_distance = d;
      best = name;
    }
  }
  return best;
}

std::string one_of(std::string_view found, const std::vector<std::string>& names, std::string_view many) {
  if (names.empty()) return "none, as there are no " + std::string(many);
  if (names.size() == 1) return names.front();
  const std::string canonical = canonical_name(found, names);
  const std::string near = canonical.empty() ? nearest(found, names) : canonical;
  const std::string hint = near.empty() ? "" : "; did you mean '" + near + "'?";
  if (names.size() > 30) return "one of " + std::to_string(names.size()) + " " + std::string(many) + hint;
  // A list of up to four names needs no suggestion for a misspelled one.
  return "one of " + list(names) + (names.size() > 4 || !canonical.empty() ? hint : "");
}

namespace {

// UTF-8 sequences by their first byte (Unicode 15, table 3-7). The bounds of the second byte exclude overlong
// encodings, surrogates and code points beyond U+10FFFF.
struct Utf8Range {
  unsigned char first, last;  // range of the first byte
  std::size_t more;           // number of further bytes
  unsigned char low, high;    // range of the second byte
};
constexpr Utf8Range utf8_ranges[] = {
    {0x00, 0x7f, 0, 0, 0},       {0xc2, 0xdf, 1, 0x80, 0xbf}, {0xe0, 0xe0, 2, 0xa0, 0xbf},
    {0xe1, 0xec, 2, 0x80, 0xbf}, {0xed, 0xed, 2, 0x80, 0x9f}, {0xee, 0xef, 2, 0x80, 0xbf},
    {0xf0, 0xf0, 3, 0x90, 0xbf}, {0xf1, 0xf3, 3, 0x80, 0xbf}, {0xf4, 0xf4, 3, 0x80, 0x8f}};

// Returns the number of bytes of the UTF-8 sequence with which s begins, or 0 if the sequence is invalid.
std::size_t sequence_length(std::string_view s) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const auto* const found =
      std::ranges::find_if(utf8_ranges, [&](const Utf8Range& r) { return r.first <= byte(0) && byte(0) <= r.last; });
  if (found == std::end(utf8_ranges) || s.size() <= found->more) return 0;
  if (found->more > 0 && (byte(1) < found->low || byte(1) > found->high)) return 0;
  for (std::size_t k = 2; k <= found->more; ++k) {
    if ((byte(k) & 0xc0) != 0x80) return 0;
  }
  return found->more + 1;
}

}  // namespace

std::size_t first_not_utf8(std::string_view s) {
  std::size_t i = 0;
  while (i < s.size()) {
    const std::size_t size = sequence_length(s.substr(i));
    if (size == 0) return i;
    i += size;
  }
  return std::string_view::npos;
}

bool is_identifier(std::string_view name) {
  return !name.empty() && is_letter(name[0]) &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c); });
}

}  // namespace gelenk::text
