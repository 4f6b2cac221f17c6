// SPDX-License-Identifier: BSD-3-Clause
// Text of error messages: formatted numbers, lists of names, spelling suggestions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gelenk::text {

// A letter of ASCII in lower case; others unchanged.
inline char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Replaces every occurrence of the placeholder in the text.
void replace(std::string& text, std::string_view placeholder, std::string_view by);

// Returns the shortest decimal that reads back to the same bits: "0.1", "1e-06", "NaN".
std::string number(double x);

// Returns a computed number with this many significant digits, without the rounding errors in its last ones.
std::string rounded(double x, int digits = 6);

// "0.5 kg"; only the number if the unit is empty.
std::string with_unit(const std::string& value, std::string_view unit);

// "a, b, c".
std::string list(const std::vector<std::string>& names);

// "a, b and c"; of more than 8 names the first 6: "a, b, c, d, e, f and 994 more".
std::string some(const std::vector<std::string>& names);

// Text of a file in a form that fits on one line: control characters escaped, longer text cut after 60 bytes.
std::string printable(std::string_view raw);
// The same in single quotes.
std::string quoted(std::string_view raw);

// Returns the name closest to `found` if a typing error explains the difference; otherwise an empty string.
std::string nearest(std::string_view found, const std::vector<std::string>& names);

// "one of ground, crank", with a suggestion if the list is long; more than 24 names are not listed.
// many: plural noun for the names, "bodies".
std::string one_of(std::string_view found, const std::vector<std::string>& names, std::string_view many);

// Returns the index of the first byte that is not valid UTF-8 (RFC 3629), or npos.
std::size_t first_not_utf8(std::string_view s);

// Whether the name is a letter or _, followed by letters, digits or _, as FMI's structured names require.
bool is_identifier(std::string_view name);

}  // namespace gelenk::text
