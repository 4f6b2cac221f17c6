// SPDX-License-Identifier: BSD-3-Clause
#include "field/formula.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "expression/parse.h"

namespace gelenk {

Formula::Formula(std::string text, std::span<const FormulaVariable> variables, const FormulaNames& known,
                 bool reads_signals) {
  const auto parsed = std::make_shared<Parsed>();
  parsed->text = std::move(text);
  parsed->count = variables.size();
  expression::Graph& graph = parsed->graph;
  std::vector<std::string>& named = parsed->signals;
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
    if (found != variables.end()) return graph.variable(static_cast<int>(found - variables.begin()));
    const auto constant = std::ranges::find(known.constants, name, &FormulaNames::Constant::name);
    if (constant != known.constants.end()) return graph.constant(constant->value);
    if (std::ranges::find(signals, name) == signals.end()) return std::nullopt;
    const auto signal = std::ranges::find(named, name);
    const auto k = static_cast<std::size_t>(signal - named.begin());
    if (signal == named.end()) named.emplace_back(name);
    if (name == time_signal) parsed->clock = k;
    return graph.variable(static_cast<int>(variables.size() + k));
  };
  parsed->term = expression::parse(graph, parsed->text, names);
  if (named.size() > max_signals) {
    throw expression::SyntaxError(0, parsed->text.size(),
                                  "found " + std::to_string(named.size()) + " inputs and t, expected at most " +
                                      std::to_string(max_signals) + " in one expression");
  }
  try {
    parsed->tape = expression::Tape(graph, std::vector{parsed->term});
  } catch (const std::length_error& error) {
    throw expression::SyntaxError(0, parsed->text.size(), error.what());
  }
  parsed_ = parsed;
  std::ranges::fill(signal_sizes_, 1.0);
}

void Formula::renew(std::span<const FormulaVariable> variables, const FormulaNames& names, bool reads_signals) {
  Formula renewed(std::string(text()), variables, names, reads_signals);
  renewed.set_sizes(size_, sizes_);
  *this = std::move(renewed);
}

void Formula::set_sizes(double of_result, std::span<const double> of_variables) {
  size_ = of_result;
  std::ranges::copy(of_variables, sizes_);
}

}  // namespace gelenk
