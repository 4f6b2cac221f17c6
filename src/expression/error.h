// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gelenk::expression {

// A mistake in the text of an expression: its place, in bytes, and what was found and is expected.
class SyntaxError : public std::runtime_error {
 public:
  SyntaxError(std::size_t place, std::size_t length, const std::string& text)
      : std::runtime_error(text), place(place), length(length) {}
  std::size_t place, length;
};

// The message in three lines: what is wrong at which column, from 1, the line of the text, and ^^^ below the place.
std::string with_caret(const SyntaxError& error, std::string_view text);

}  // namespace gelenk::expression
