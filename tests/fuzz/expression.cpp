// SPDX-License-Identifier: BSD-3-Clause
// The reader of expressions: any text gives a formula or a SyntaxError within the text; formulas and their derivatives
// can be evaluated anywhere, on any branches.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "expression/error.h"
#include "field/formula.h"
#include "math/dual.h"
#include "math/series.h"

namespace {

using gelenk::Dual;
using gelenk::Formula;
using gelenk::Series;

gelenk::FormulaNames names() {
  gelenk::FormulaNames out;
  out.constants = {{"k", 3.5}, {"none", 0}};
  out.signals = {"u", "state"};
  out.expressions = {{"named", "k*u + A.phi"}, {"a1", "a2 + 1"}, {"a2", "a1"}};
  const auto table = [](gelenk::expression::Table::Data data) {
    return std::make_shared<const gelenk::expression::Table>(std::move(data));
  };
  out.tables = {{"curve", table({.name = "curve", .x = {0, 1, 2.5}, .y = {}, .values = {1, -1, 4}})},
                {"map", table({.name = "map", .x = {0, 1}, .y = {0, 2}, .values = {1, 2, 3, -4}})},
                {"faulty", nullptr}};
  out.coordinates =
      std::make_shared<const std::unordered_set<std::string>>(std::unordered_set<std::string>{"A.phi", "tip.r[1]"});
  out.forces = std::make_shared<const std::unordered_set<std::string>>(std::unordered_set<std::string>{"A.a"});
  return out;
}

template <class T>
void evaluate(const Formula& formula) {
  constexpr double values[] = {0, -0.0, 1, -2.5, 1e308, -1e-308};
  for (const double value : values) {
    std::array<T, Formula::max_variables> variables;
    std::array<T, Formula::max_signals> signals;
    variables.fill(T(value));
    signals.fill(T(value));
    std::vector<T> arguments(static_cast<std::size_t>(formula.branches()));
    static_cast<void>(formula.value<T>(variables.data(), signals.data()));
    static_cast<void>(formula.decide<T>(variables.data(), signals.data(), arguments.data()));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const gelenk::FormulaNames known = names();
  static constexpr gelenk::FormulaVariable variables[] = {{"phi", "rad"}, {"w", "rad/s"}};
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const Formula formula(text, variables, known, gelenk::FormulaReads::forces, {.lower = 0, .upper = 1});
    evaluate<double>(formula);
    evaluate<Dual>(formula);
    evaluate<Series>(formula);
    gelenk::expression::Graph graph = formula.graph();
    if (graph.size() < 2000) {
      for (int variable = 0; variable < 2; ++variable)
        static_cast<void>(derivative(graph, derivative(graph, formula.term(), variable), 1 - variable));
    }
  } catch (const gelenk::expression::SyntaxError& error) {
    if (with_caret(error, text).empty()) std::abort();
  }
  return 0;
}
