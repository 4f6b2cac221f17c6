// SPDX-License-Identifier: BSD-3-Clause
#include "field/formula.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "expression/parse.h"

namespace gelenk {

Formula::Formula(std::string text, std::span<const FormulaVariable> variables) : text_(std::move(text)) {
  const auto graph = std::make_shared<expression::Graph>();
  expression::Names names;
  for (const FormulaVariable& variable : variables) {
    if (!variable.name.empty()) names.known.emplace_back(variable.name);
  }
  names.find = [&](std::string_view name) -> std::optional<expression::Term> {
    const auto found = std::ranges::find(variables, name, &FormulaVariable::name);
    if (found == variables.end()) return std::nullopt;
    return graph->variable(static_cast<int>(found - variables.begin()));
  };
  term_ = expression::parse(*graph, text_, names);
  try {
    tape_ = std::make_shared<const expression::Tape>(*graph, std::vector{term_});
  } catch (const std::length_error& error) {
    throw expression::SyntaxError(0, text_.size(), error.what());
  }
  graph_ = graph;
  count_ = variables.size();
}

void Formula::set_sizes(double of_result, std::span<const double> of_variables) {
  size_ = of_result;
  std::ranges::copy(of_variables, sizes_);
}

}  // namespace gelenk
