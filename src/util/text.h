// SPDX-License-Identifier: BSD-3-Clause
// Words of error messages: numbers as people write them, lists of names, the name that was probably meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gelenk::text {

// Wherever the placeholder stands in the text.
void replace(std::string& text, std::string_view placeholder, std::string_view by);

// The shortest decimal that reads back to the same bits: "0.1", "1e-06", "NaN".
std::string number(double x);

// A number we computed, to that many digits: rounding in its last places is of no interest.
std::string rounded(double x, int digits = 6);

// "0.5 kg"; the bare number where there is no unit.
std::string with_unit(const std::string& value, std::string_view unit);

// "a, b, c".
std::string list(const std::vector<std::string>& names);

// "a, b and c"; of many names the first few: "a, b, c, d, e and 995 more".
std::string some(const std::vector<std::string>& names);

// What a file says, made fit for one line: control characters escaped, at most 60 bytes.
std::string printable(std::string_view raw);
std::string quoted(std::string_view raw);

// The name closest to `found` if a slip of the fingers explains the difference; else empty.
std::string nearest(std::string_view found, const std::vector<std::string>& names);

// "one of ground, crank" with a proposal where the list is long; of more than 14 names the list is left out.
// many: what these are, "bodies".
std::string one_of(std::string_view found, const std::vector<std::string>& names, std::string_view many);

// The place of the first byte that is not UTF-8 (RFC 3629), or npos.
std::size_t first_not_utf8(std::string_view s);

// A letter or _, then letters, digits or _: what FMI's structured names take.
bool is_identifier(std::string_view name);

}  // namespace gelenk::text
