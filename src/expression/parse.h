// SPDX-License-Identifier: BSD-3-Clause
// Reads expressions such as
//
//   -k*s^3 - d*v*abs(v) + if(s > 0 and v > 0, 2.5e3, 0)*exp(-t/T)
//
// Operators, from the weakest: or, and, not, comparisons, + -, * /, the sign, ^ (from right to left). Comparisons are
// conditions of `if` only. Functions: those of one argument in graph.h, atan2(y, x), hypot(x, y), pow(x, y), abs, sign,
// min and max of two or more, clip(x, lower, upper), smoothstep(x, from, to), if(condition, a, b), table(name, x) or
// table(name, x, y). pi is a constant.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "expression/error.h"
#include "expression/graph.h"
#include "expression/table.h"

namespace gelenk::expression {

struct NamedTable {
  std::string name;
  std::shared_ptr<const Table> table;  // null: it has faults
};

struct Names {
  std::function<std::optional<Term>(std::string_view)> find;  // the term with a name
  std::function<std::vector<std::string>()> known;            // all of them, for suggestions
  // What to say of a name that is unknown, instead of a suggestion; empty: nothing. May be empty itself.
  std::function<std::string(std::string_view)> advice{};
  const std::vector<NamedTable>* tables = nullptr;  // null: none
};

inline constexpr std::size_t max_length = 10'000;  // of a text, in bytes

// Returns the term of the text in the graph. Throws SyntaxError.
Term parse(Graph& graph, std::string_view text, const Names& names);

}  // namespace gelenk::expression
