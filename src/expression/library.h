// SPDX-License-Identifier: BSD-3-Clause
// The functions that expressions may call, by name, and advice where a name is wrong.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "expression/graph.h"

namespace gelenk::expression {

class Library {
 public:
  explicit Library(Graph& graph) : graph_(graph) {}

  static bool has(std::string_view name);
  static std::vector<std::string> names();
  // The least and the largest number of arguments of a function that there is.
  static std::pair<int, int> arguments(std::string_view name);
  // How it is called: "clip(x, lower, upper)".
  static std::string form(std::string_view name);
  // Not for `if`, whose first argument is a condition.
  Term applied(std::string_view name, const std::vector<Term>& arguments);

 private:
  Term absolute(Term x);
  Term least(Term a, Term b);
  Term largest(Term a, Term b);

  Graph& graph_;
};

// What is meant by an unknown name of a number or a function, as the end of a message.
std::string advice_on_name(std::string_view name, const std::vector<std::string>& known);
std::string advice_on_function(std::string_view name);
// What to write instead of a number with a unit; empty if the name is no unit.
std::string advice_on_unit(std::string_view number, std::string_view name);

}  // namespace gelenk::expression
