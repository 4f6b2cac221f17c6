// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/relation_law_impl.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/dual.h"
#include "math/series.h"

namespace gelenk {
RelationLaw::RelationLaw(const Formula& f, std::vector<Named> named, int terms, bool gives)
    : named_(std::move(named)), terms_(terms) {
  expression::Graph graph = f.graph();
  Term value = f.term();
  if (gives) value = graph.subtract(graph.variable(static_cast<int>(named_.size()) - 1), value);
  is_of_rates_ = std::ranges::any_of(named_, &Named::is_rate);
  const std::vector<Term> factors = factors_of(graph, value);
  std::vector<Term> all = {value};
  all.insert(all.end(), factors.begin(), factors.end());
  first_ = expression::Tape(graph, all);
  // The rates of what is named follow as variables, of rates only those of coordinates.
  const auto count = static_cast<int>(named_.size());
  const auto change_of = [&](Term term) {
    Term out = graph.constant(0);
    for (int k = 0; k < count; ++k) {
      if (named_[static_cast<std::size_t>(k)].is_rate) continue;
      out = graph.add(out, graph.multiply(derivative(graph, term, k), graph.variable(count + k)));
    }
    return out;
  };
  all = factors;
  if (is_of_rates_) {
    all.push_back(change_of(value));
    for (int k = 0; k < count; ++k) {
      const auto depends = [&](Term factor) { return graph.depends_on(factor, k); };
      if (named_[static_cast<std::size_t>(k)].is_rate)
        is_linear_ = is_linear_ && std::ranges::none_of(factors, depends);
    }
  } else {
    for (const Term factor : factors) all.push_back(change_of(factor));
  }
  second_ = expression::Tape(graph, all);
}

// By coordinate, in their units: with x = X/size, df/dx = size df/dX.
std::vector<RelationLaw::Term> RelationLaw::factors_of(expression::Graph& graph, Term value) const {
  std::vector<Term> out(static_cast<std::size_t>(terms_), graph.constant(0));
  for (std::size_t k = 0; k < named_.size(); ++k) {
    if (named_[k].is_rate != is_of_rates_) continue;
    Term& factor = out[static_cast<std::size_t>(named_[k].term)];
    const Term by = derivative(graph, value, static_cast<int>(k));
    factor = graph.add(factor, graph.multiply(graph.constant(named_[k].size), by));
  }
  return out;
}

bool RelationLaw::is_regular(const double* x, const double* rates) const {
  double factors[most_terms];
  const double at = value(x, rates, factors);
  return std::isfinite(at) && std::isfinite(bias(x, rates));
}

template double RelationLaw::value(const double*, const double*, double*) const;
template Dual RelationLaw::value(const Dual*, const Dual*, Dual*) const;
template Series RelationLaw::value(const Series*, const Series*, Series*) const;
template double RelationLaw::bias(const double*, const double*) const;
template Dual RelationLaw::bias(const Dual*, const Dual*) const;
template Series RelationLaw::bias(const Series*, const Series*) const;

}  // namespace gelenk
