// SPDX-License-Identifier: BSD-3-Clause
// The words of an expression: numbers, names and operators.
#pragma once

#include <string_view>
#include <vector>

#include "expression/error.h"

namespace gelenk::expression {

struct Token {
  enum class Kind { number, name, symbol, end };
  Kind kind = Kind::end;
  std::string_view text;  // of the expression
  std::size_t place = 0;  // in bytes
  double value = 0;       // of a number

  bool is(std::string_view symbol) const { return kind != Kind::number && text == symbol; }
};

// Names are identifiers, joined by dots, and perhaps an index: joint.phi, tip.r[1]. The last token is the end.
// Throws SyntaxError for characters that mean nothing, with what is written instead.
std::vector<Token> tokens(std::string_view text);

}  // namespace gelenk::expression
