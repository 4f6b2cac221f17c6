// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/motion_terms.h"

#include <algorithm>
#include <set>

#include "recorded/elimination.h"

namespace gelenk {
namespace {

using expression::Graph;
using expression::Term;
using recording::Recorded;

// Indices of variables of which no one is an argument of the equations.
constexpr int first_residual = 1 << 21;

Elimination::Numbers numbers(const Terms& of) {
  Elimination::Numbers out;
  for (const Term term : of) out.push_back(Recorded::of(term));
  return out;
}

}  // namespace

Terms terms(const std::vector<Recorded>& of) {
  Terms out;
  for (const Recorded& x : of) out.push_back(x.term());
  return out;
}

bool is_residual(int variable) { return variable >= first_residual; }

MotionTerms::MotionTerms(const Graph& graph, const EquationTerms& of, const Pivots& pivots) {
  const Elimination elimination(of, pivots);
  accelerations = terms(elimination.accelerations(numbers(of_pivots(of.gamma, pivots)), numbers(of.h)));
  Elimination::Numbers residuals;
  for (int i = 0; i < static_cast<int>(pivots.rows.size()); ++i)
    residuals.push_back(Recorded::variable(first_residual + i));
  residual = terms(residuals);
  if (!residual.empty()) displacement = terms(elimination.displacement(residuals));
  reciprocal_pivots = terms(elimination.reciprocal_pivots());
  reciprocal_masses = terms(elimination.reciprocal_masses());
  free = elimination.free();
  factors = independent_parts(graph, displacement, is_residual);
  add_varying(graph, reciprocal_pivots, factors);
  add_varying(graph, reciprocal_masses, factors);
}

Terms of_pivots(const Terms& by_row, const Pivots& pivots) {
  Terms out;
  for (const int row : pivots.rows) out.push_back(by_row[static_cast<std::size_t>(row)]);
  return out;
}

void add_varying(const Graph& graph, const Terms& of, Terms& to) {
  for (const Term term : of) {
    if (!graph.is_constant(term) && std::ranges::find(to, term) == to.end()) to.push_back(term);
  }
}

Terms independent_parts(const Graph& graph, const Terms& of, const std::function<bool(int)>& depends) {
  std::vector<bool> varies(static_cast<std::size_t>(graph.size()), false);
  for (Term term = 0; term < graph.size(); ++term) {
    const expression::Node& node = graph[term];
    const auto at = static_cast<std::size_t>(term);
    varies[at] = node.operation == expression::Operation::variable && depends(node.index);
    for (const Term operand : node.of)
      varies[at] = varies[at] || (operand >= 0 && varies[static_cast<std::size_t>(operand)]);
  }
  std::set<Term> out;
  std::vector<bool> is_seen(varies.size(), false);
  Terms waiting = of;
  while (!waiting.empty()) {
    const Term term = waiting.back();
    waiting.pop_back();
    if (is_seen[static_cast<std::size_t>(term)]) continue;
    is_seen[static_cast<std::size_t>(term)] = true;
    if (!varies[static_cast<std::size_t>(term)]) {
      if (!graph.is_constant(term)) out.insert(term);
      continue;
    }
    for (const Term operand : graph[term].of) {
      if (operand >= 0) waiting.push_back(operand);
    }
  }
  return {out.begin(), out.end()};
}

}  // namespace gelenk
