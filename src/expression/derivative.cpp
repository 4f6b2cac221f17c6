// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <vector>

#include "expression/graph.h"

namespace gelenk::expression {
namespace {

class Differentiator {
 public:
  Differentiator(Graph& graph, int variable) : g_(graph), variable_(variable) {}

  Term of(Term term) {
    const std::vector<bool> needed = g_.parts_of({&term, 1});
    d_.assign(needed.size(), -1);
    for (Term at = 0; at <= term; ++at) {
      if (needed[static_cast<std::size_t>(at)]) d_[static_cast<std::size_t>(at)] = of_node(at);
    }
    return d(term);
  }

 private:
  Term d(Term term) const { return d_[static_cast<std::size_t>(term)]; }
  Term one() { return g_.constant(1); }
  Term square(Term a) { return g_.integer_power(a, 2); }
  // x / sqrt(radicand)
  Term over_root(Term x, Term radicand) { return g_.divide(x, g_.function(Operation::sqrt, radicand)); }

  Term of_node(Term at) {
    const Node node = g_[at];
    const auto [a, b, c] = node.of;
    switch (node.operation) {
      case Operation::constant:
        return g_.constant(0);
      case Operation::variable:
        return g_.constant(node.index == variable_ ? 1 : 0);
      case Operation::add:
        return g_.add(d(a), d(b));
      case Operation::subtract:
        return g_.subtract(d(a), d(b));
      case Operation::multiply:
        return g_.add(g_.multiply(d(a), b), g_.multiply(a, d(b)));
      case Operation::divide:
        return g_.divide(g_.subtract(d(a), g_.multiply(at, d(b))), b);
      case Operation::negate:
        return g_.negate(d(a));
      case Operation::integer_power:
        return g_.multiply(g_.multiply(g_.constant(node.index), g_.integer_power(a, node.index - 1)), d(a));
      case Operation::power:
        return of_power(at, a, b);
      case Operation::choose:
        return g_.choose(a, d(b), d(c));
      case Operation::lookup:
        return of_lookup(node);
      case Operation::atan2:
        return g_.divide(g_.subtract(g_.multiply(b, d(a)), g_.multiply(a, d(b))), g_.add(square(a), square(b)));
      default:
        return g_.is_constant(d(a), 0) ? d(a) : of_function(node.operation, at, a, d(a));
    }
  }

  Term of_lookup(const Node& node) {
    const Graph::Lookup looked_up = g_.lookup(node.index);
    Term out = g_.constant(0);
    for (std::size_t k = 0; k < looked_up.table->arguments(); ++k) {
      if (g_.is_constant(d(node.of[k]), 0)) continue;
      Table::Orders orders = looked_up.derivatives;
      ++orders[k];
      const Term along = g_.look_up(looked_up.table, node.of[0], node.of[1], orders);
      out = g_.add(out, g_.multiply(along, d(node.of[k])));
    }
    return out;
  }

  Term of_power(Term at, Term a, Term b) {
    if (g_.is_constant(d(b), 0)) {
      return g_.multiply(g_.multiply(b, g_.power(a, g_.subtract(b, one()))), d(a));
    }
    const Term by_exponent = g_.multiply(d(b), g_.function(Operation::log, a));
    return g_.multiply(at, g_.add(by_exponent, g_.divide(g_.multiply(b, d(a)), a)));
  }

  // at: the function of a. da: the derivative of a.
  Term of_function(Operation operation, Term at, Term a, Term da) {
    switch (operation) {
      case Operation::sin:
        return g_.multiply(g_.function(Operation::cos, a), da);
      case Operation::cos:
        return g_.negate(g_.multiply(g_.function(Operation::sin, a), da));
      case Operation::tan:
        return g_.multiply(g_.add(one(), square(at)), da);
      case Operation::asin:
        return over_root(da, g_.subtract(one(), square(a)));
      case Operation::acos:
        return g_.negate(over_root(da, g_.subtract(one(), square(a))));
      case Operation::atan:
        return g_.divide(da, g_.add(one(), square(a)));
      case Operation::sinh:
        return g_.multiply(g_.function(Operation::cosh, a), da);
      case Operation::cosh:
        return g_.multiply(g_.function(Operation::sinh, a), da);
      case Operation::tanh:
        return g_.multiply(g_.subtract(one(), square(at)), da);
      case Operation::asinh:
        return over_root(da, g_.add(one(), square(a)));
      case Operation::acosh:
        return over_root(da, g_.subtract(square(a), one()));
      case Operation::atanh:
        return g_.divide(da, g_.subtract(one(), square(a)));
      case Operation::exp:
        return g_.multiply(at, da);
      case Operation::log:
        return g_.divide(da, a);
      case Operation::log10:
        return g_.divide(g_.multiply(g_.constant(std::numbers::log10e), da), a);
      case Operation::sqrt:
        return g_.divide(da, g_.multiply(g_.constant(2), at));
      case Operation::cbrt:
        return g_.divide(da, g_.multiply(g_.constant(3), square(at)));
      default:  // erf
        return g_.multiply(
            g_.multiply(g_.constant(2 * std::numbers::inv_sqrtpi), g_.function(Operation::exp, g_.negate(square(a)))),
            da);
    }
  }

  Graph& g_;
  int variable_;
  std::vector<Term> d_;  // by term
};

}  // namespace

Term derivative(Graph& graph, Term term, int variable) { return Differentiator(graph, variable).of(term); }

}  // namespace gelenk::expression
