// SPDX-License-Identifier: BSD-3-Clause
#include "field/formula.h"

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "expression/parse.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::vector<std::string> all_names(std::span<const FormulaVariable> variables, const FormulaNames& known,
                                   FormulaReads reads) {
  std::vector<std::string> out;
  for (const FormulaVariable& variable : variables) {
    if (!variable.name.empty()) out.emplace_back(variable.name);
  }
  for (const FormulaNames::Constant& constant : known.constants) out.push_back(constant.name);
  if (reads == FormulaReads::nothing) return out;
  out.insert(out.end(), known.signals.begin(), known.signals.end());
  out.emplace_back(time_signal);
  if (known.coordinates != nullptr) out.insert(out.end(), known.coordinates->begin(), known.coordinates->end());
  if (reads == FormulaReads::forces && known.forces != nullptr)
    out.insert(out.end(), known.forces->begin(), known.forces->end());
  for (const FormulaNames::Expression& expression : known.expressions) out.push_back(expression.name);
  return out;
}

// Reads a text into the graph of a formula.
class FormulaParser {
 public:
  FormulaParser(expression::Graph& graph, std::span<const FormulaVariable> variables, const FormulaNames& known,
                FormulaReads reads, std::vector<std::string>& named)
      : graph_(graph), variables_(variables), known_(known), reads_(reads), named_(named) {}

  const std::vector<std::string>& forces() const { return forces_; }

  expression::Term read(std::string_view text) { return read(text, variables_); }

 private:
  static constexpr int max_depth = 50;  // of expressions that name each other

  expression::Term read(std::string_view text, std::span<const FormulaVariable> variables) {
    expression::Names names;
    names.known = [&] { return all_names(variables, known_, reads_); };
    names.find = [&](std::string_view name) { return find(name, variables); };
    names.advice = [&](std::string_view name) { return advice(name); };
    names.tables = &known_.tables;
    return expression::parse(graph_, text, names);
  }

  std::optional<expression::Term> find(std::string_view name, std::span<const FormulaVariable> variables) {
    const auto found = std::ranges::find(variables, name, &FormulaVariable::name);
    if (found != variables.end()) return graph_.variable(static_cast<int>(found - variables.begin()));
    const auto constant = std::ranges::find(known_.constants, name, &FormulaNames::Constant::name);
    if (constant != known_.constants.end()) return graph_.constant(constant->value);
    if (reads_ == FormulaReads::nothing) return std::nullopt;
    const auto expression = std::ranges::find(known_.expressions, name, &FormulaNames::Expression::name);
    if (expression != known_.expressions.end()) return inserted(*expression);
    const bool is_force = reads_ == FormulaReads::forces && is_of(known_.forces, name);
    if (!is_force && !is_signal(name)) return std::nullopt;
    if (is_force && std::ranges::find(forces_, name) == forces_.end()) forces_.emplace_back(name);
    const auto signal = std::ranges::find(named_, name);
    const auto k = static_cast<std::size_t>(signal - named_.begin());
    if (signal == named_.end()) named_.emplace_back(name);
    return graph_.variable(static_cast<int>(variables_.size() + k));
  }

  bool is_signal(std::string_view name) const {
    if (known_.any || name == time_signal) return true;
    if (std::ranges::find(known_.signals, name) != known_.signals.end()) return true;
    return is_of(known_.coordinates, name);
  }
  static bool is_of(const std::shared_ptr<const std::unordered_set<std::string>>& names, std::string_view name) {
    return names != nullptr && names->contains(std::string(name));
  }

  // On a name with a point that nothing has, although there is a joint or a sensor before the point.
  std::string advice(std::string_view name) const {
    const std::size_t point = name.find('.');
    if (point == name.npos || reads_ == FormulaReads::nothing || known_.coordinates == nullptr) return {};
    std::vector<std::string> of_owner;
    const auto look = [&](const std::unordered_set<std::string>& names) {
      for (const std::string& one : names) {
        if (one.starts_with(name.substr(0, point + 1))) of_owner.push_back(one);
      }
    };
    look(*known_.coordinates);
    if (reads_ == FormulaReads::forces && known_.forces != nullptr) look(*known_.forces);
    if (of_owner.empty()) return {};
    std::ranges::sort(of_owner);
    const std::string near = text::nearest(name, of_owner);
    return "expected one of " + text::list(of_owner) + (near.empty() ? "" : "; did you mean '" + near + "'?") +
           (reads_ == FormulaReads::forces
                ? ""
                : " (accelerations and forces can be named only by rates of states, and by `expressions` that nothing "
                  "but these and outputs reads)");
  }

  // Of a named expression, which knows no variables of elements. A mistake in it is that of its own section. Each is
  // read once, however often it is named: expressions that name others twice would double at every level.
  expression::Term inserted(const FormulaNames::Expression& expression) {
    if (const auto known = inserted_.find(expression.name); known != inserted_.end()) return known->second;
    if (depth_ == max_depth) {
      throw expression::SyntaxError(0, 1,
                                    "found expressions that name each other in a circle, or 50 within each other");
    }
    ++depth_;
    const expression::Term out = read(expression.text, {});
    --depth_;
    inserted_.emplace(expression.name, out);
    return out;
  }

  expression::Graph& graph_;
  std::span<const FormulaVariable> variables_;
  const FormulaNames& known_;
  FormulaReads reads_;
  std::vector<std::string> forces_;
  std::vector<std::string>& named_;
  int depth_ = 0;
  std::unordered_map<std::string_view, expression::Term> inserted_;  // by name
};

// What is no number stays none.
expression::Term bounded(expression::Graph& graph, expression::Term term, const FormulaBounds& bounds) {
  if (bounds.lower > -HUGE_VAL) {
    const expression::Term lower = graph.constant(bounds.lower);
    term = graph.choose(graph.subtract(lower, term), lower, term);
  }
  if (bounds.upper < HUGE_VAL) {
    const expression::Term upper = graph.constant(bounds.upper);
    term = graph.choose(graph.subtract(term, upper), upper, term);
  }
  return term;
}

}  // namespace

Formula::Formula(std::string text, std::span<const FormulaVariable> variables, const FormulaNames& known,
                 FormulaReads reads, const FormulaBounds& bounds) {
  const auto parsed = std::make_shared<Parsed>();
  parsed->text = std::move(text);
  parsed->count = variables.size();
  std::vector<std::string>& named = parsed->signals;
  FormulaParser parser(parsed->graph, variables, known, reads, named);
  parsed->term = parser.read(parsed->text);
  parsed->forces = parser.forces();
  parsed->reads = reads;
  parsed->bounds = bounds;
  if (!parsed->graph.is_constant(parsed->term)) parsed->term = bounded(parsed->graph, parsed->term, bounds);
  parsed->finish();
  parsed_ = parsed;
  std::ranges::fill(signal_sizes_, 1.0);
}

void Formula::Parsed::finish() {
  clock = static_cast<std::size_t>(std::ranges::find(signals, time_signal) - signals.begin());
  if (signals.size() > max_signals) {
    throw expression::SyntaxError(0, text.size(),
                                  "found " + std::to_string(signals.size()) +
                                      " inputs, states and coordinates, expected at most " +
                                      std::to_string(max_signals) + " in one expression");
  }
  try {
    tape = expression::Tape(graph, std::vector{term}, reads_clock() ? static_cast<int>(count + clock) : -1);
  } catch (const std::length_error& error) {
    throw expression::SyntaxError(0, text.size(), error.what());
  }
  for (int i = 0; i < tape.choices() && !forces.empty(); ++i) {
    by_forces.push_back(std::ranges::any_of(forces, [&](const std::string& force) {
      const auto signal = std::ranges::find(signals, force) - signals.begin();
      return graph.depends_on(tape.deciding(i), static_cast<int>(count + static_cast<std::size_t>(signal)));
    }));
  }
  if (std::ranges::find(by_forces, true) == by_forces.end()) by_forces.clear();
  if (by_forces.size() > most_by_forces) {
    throw expression::SyntaxError(0, text.size(),
                                  "found " + std::to_string(by_forces.size()) +
                                      " kinks and points of tables, expected at most " +
                                      std::to_string(most_by_forces) + " where forces decide on some");
  }
}

Formula time_derivative(const Formula& of, const FormulaNames& known, const Formula::RateOf& rate_of) {
  const auto derived = std::make_shared<Formula::Parsed>(*of.parsed_);
  expression::Graph& graph = derived->graph;
  FormulaParser parser(graph, {}, known, FormulaReads::signals, derived->signals);
  expression::Term sum = graph.constant(0);
  for (std::size_t k = 0; k < of.parsed_->signals.size(); ++k) {
    const std::string& signal = of.parsed_->signals[k];
    const expression::Term along = derivative(graph, of.parsed_->term, static_cast<int>(k));
    if (graph.is_constant(along, 0)) continue;
    expression::Term rate = graph.constant(1);
    if (signal != time_signal) {
      const std::optional<std::string> text = rate_of(signal);
      if (!text) throw expression::SyntaxError(0, of.parsed_->text.size(), "'" + signal + "' has no rate");
      rate = parser.read(*text);
    }
    sum = graph.add(sum, graph.multiply(along, rate));
  }
  derived->term = sum;
  derived->finish();
  Formula out;
  out.parsed_ = derived;
  std::ranges::fill(out.signal_sizes_, 1.0);
  return out;
}

void Formula::renew(std::span<const FormulaVariable> variables, const FormulaNames& names) {
  Formula renewed(std::string(text()), variables, names, parsed_->reads, parsed_->bounds);
  renewed.set_sizes(size_, sizes_);
  *this = std::move(renewed);
}

void Formula::set_sizes(double of_result, std::span<const double> of_variables) {
  size_ = of_result;
  std::ranges::copy(of_variables, sizes_);
}

}  // namespace gelenk
