// SPDX-License-Identifier: BSD-3-Clause
#include "field/formula.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "expression/parse.h"

namespace gelenk {

Formula::Formula(std::string text, std::span<const FormulaVariable> variables, const FormulaNames& known,
                 bool reads_signals)
    : text_(std::move(text)) {
  const auto graph = std::make_shared<expression::Graph>();
  expression::Names names;
  for (const FormulaVariable& variable : variables) {
    if (!variable.name.empty()) names.known.emplace_back(variable.name);
  }
  for (const FormulaNames::Constant& constant : known.constants) names.known.push_back(constant.name);
  std::vector<std::string> signals;
  if (reads_signals) {
    signals = known.signals;
    signals.emplace_back(time_signal);
    names.known.insert(names.known.end(), signals.begin(), signals.end());
  }
  names.find = [&](std::string_view name) -> std::optional<expression::Term> {
    const auto found = std::ranges::find(variables, name, &FormulaVariable::name);
    if (found != variables.end()) return graph->variable(static_cast<int>(found - variables.begin()));
    const auto constant = std::ranges::find(known.constants, name, &FormulaNames::Constant::name);
    if (constant != known.constants.end()) return graph->constant(constant->value);
    if (std::ranges::find(signals, name) == signals.end()) return std::nullopt;
    const auto signal = std::ranges::find(signal_names_, name);
    const auto k = static_cast<std::size_t>(signal - signal_names_.begin());
    if (signal == signal_names_.end()) signal_names_.emplace_back(name);
    return graph->variable(static_cast<int>(variables.size() + k));
  };
  term_ = expression::parse(*graph, text_, names);
  if (signal_names_.size() > max_signals) {
    throw expression::SyntaxError(0, text_.size(),
                                  "found " + std::to_string(signal_names_.size()) + " inputs and t, expected at most " +
                                      std::to_string(max_signals) + " in one expression");
  }
  try {
    tape_ = std::make_shared<const expression::Tape>(*graph, std::vector{term_});
  } catch (const std::length_error& error) {
    throw expression::SyntaxError(0, text_.size(), error.what());
  }
  graph_ = graph;
  count_ = variables.size();
  std::ranges::fill(signal_sizes_, 1.0);
}

void Formula::renew(std::span<const FormulaVariable> variables, const FormulaNames& names, bool reads_signals) {
  Formula renewed(text_, variables, names, reads_signals);
  renewed.set_sizes(size_, sizes_);
  *this = std::move(renewed);
}

void Formula::set_sizes(double of_result, std::span<const double> of_variables) {
  size_ = of_result;
  std::ranges::copy(of_variables, sizes_);
}

void Formula::bind(std::span<const int> signals, std::span<const double> sizes, const HeldBranches* branches,
                   int first_branch) {
  std::ranges::copy(signals, signals_);
  std::ranges::copy(sizes, signal_sizes_);
  branches_ = branches;
  first_branch_ = first_branch;
}

}  // namespace gelenk
