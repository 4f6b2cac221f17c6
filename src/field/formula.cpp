// SPDX-License-Identifier: BSD-3-Clause
#include "field/formula.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "expression/parse.h"

namespace gelenk {
namespace {

std::vector<std::string> all_names(std::span<const FormulaVariable> variables, const FormulaNames& known,
                                   bool reads_signals) {
  std::vector<std::string> out;
  for (const FormulaVariable& variable : variables) {
    if (!variable.name.empty()) out.emplace_back(variable.name);
  }
  for (const FormulaNames::Constant& constant : known.constants) out.push_back(constant.name);
  if (!reads_signals) return out;
  out.insert(out.end(), known.signals.begin(), known.signals.end());
  out.emplace_back(time_signal);
  if (known.coordinates != nullptr) out.insert(out.end(), known.coordinates->begin(), known.coordinates->end());
  return out;
}

}  // namespace

Formula::Formula(std::string text, std::span<const FormulaVariable> variables, const FormulaNames& known,
                 bool reads_signals) {
  const auto parsed = std::make_shared<Parsed>();
  parsed->text = std::move(text);
  parsed->count = variables.size();
  expression::Graph& graph = parsed->graph;
  std::vector<std::string>& named = parsed->signals;
  const auto is_signal = [&](std::string_view name) {
    if (!reads_signals) return false;
    if (name == time_signal || std::ranges::find(known.signals, name) != known.signals.end()) return true;
    return known.coordinates != nullptr && known.coordinates->contains(std::string(name));
  };
  expression::Names names;
  names.known = [&] { return all_names(variables, known, reads_signals); };
  names.find = [&](std::string_view name) -> std::optional<expression::Term> {
    const auto found = std::ranges::find(variables, name, &FormulaVariable::name);
    if (found != variables.end()) return graph.variable(static_cast<int>(found - variables.begin()));
    const auto constant = std::ranges::find(known.constants, name, &FormulaNames::Constant::name);
    if (constant != known.constants.end()) return graph.constant(constant->value);
    if (!is_signal(name)) return std::nullopt;
    const auto signal = std::ranges::find(named, name);
    const auto k = static_cast<std::size_t>(signal - named.begin());
    if (signal == named.end()) named.emplace_back(name);
    if (name == time_signal) parsed->clock = k;
    return graph.variable(static_cast<int>(variables.size() + k));
  };
  parsed->term = expression::parse(graph, parsed->text, names);
  if (named.size() > max_signals) {
    throw expression::SyntaxError(0, parsed->text.size(),
                                  "found " + std::to_string(named.size()) + " inputs, states and coordinates, expected at most " +
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
