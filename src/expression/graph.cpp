// SPDX-License-Identifier: BSD-3-Clause
#include "expression/graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "expression/functions.h"
#include "expression/lookup.h"

namespace gelenk::expression {
namespace {

// The value of an operation on constants; the operands that it does not have are NaN.
double folded(const Node& node, double a, double b) {
  switch (node.operation) {
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::negate:
      return -a;
    case Operation::integer_power:
      return integer_power(a, node.index);
    case Operation::power:
      return power(a, b);
    case Operation::atan2:
      return std::atan2(a, b);
    default:
      return value_at(node.operation, a);
  }
}

}  // namespace

Term Graph::stored(const Node& node) {
  if (2 * nodes_.size() >= known_.size()) {
    constexpr std::size_t least = 64;
    known_.assign(std::max(least, 4 * nodes_.size()), -1);
    for (Term term = 0; term < size(); ++term) place_of((*this)[term]) = term;
  }
  Term& term = place_of(node);
  if (term < 0) {
    term = size();
    nodes_.push_back(node);
  }
  return term;
}

// Where the term of the node is, or has its place. The size is a power of two.
Term& Graph::place_of(const Node& node) {
  const std::size_t mask = known_.size() - 1;
  constexpr Node::Hash hash{};
  for (std::size_t at = hash(node) & mask;; at = (at + 1) & mask) {
    Term& term = known_[at];
    if (term < 0 || (*this)[term] == node) return term;
  }
}

Term Graph::made(const Node& node) {
  const auto value = [&](int k) {
    const Term term = node.of[static_cast<std::size_t>(k)];
    return term < 0 ? std::numeric_limits<double>::quiet_NaN() : (*this)[term].value;
  };
  for (const Term term : node.of) {
    if (term >= 0 && !is_constant(term)) return stored(node);
  }
  return constant(folded(node, value(0), value(1)));
}

Term Graph::constant(double x) { return stored({.value = x}); }
Term Graph::variable(int index) { return stored({.operation = Operation::variable, .index = index}); }

Term Graph::add(Term a, Term b) {
  if (is_constant(a, 0)) return b;
  if (is_constant(b, 0)) return a;
  if (a > b) std::swap(a, b);  // one node for both orders
  return made({.operation = Operation::add, .of = {a, b, -1}});
}

Term Graph::subtract(Term a, Term b) {
  if (is_constant(b, 0)) return a;
  if (is_constant(a, 0)) return negate(b);
  if (a == b) return constant(0);
  return made({.operation = Operation::subtract, .of = {a, b, -1}});
}

Term Graph::multiply(Term a, Term b) {
  if (is_constant(a, 0) || is_constant(b, 0)) return constant(0);
  if (is_constant(a, 1)) return b;
  if (is_constant(b, 1)) return a;
  if (is_constant(a, -1)) return negate(b);
  if (is_constant(b, -1)) return negate(a);
  if (a > b) std::swap(a, b);
  return made({.operation = Operation::multiply, .of = {a, b, -1}});
}

Term Graph::divide(Term a, Term b) {
  if (is_constant(b, 1)) return a;
  if (is_constant(a, 0) && !is_constant(b, 0)) return a;
  return made({.operation = Operation::divide, .of = {a, b, -1}});
}

Term Graph::negate(Term a) {
  if ((*this)[a].operation == Operation::negate) return (*this)[a].of[0];
  return made({.operation = Operation::negate, .of = {a, -1, -1}});
}

Term Graph::integer_power(Term a, int exponent) {
  if (exponent == 0) return constant(1);
  if (exponent == 1) return a;
  return made({.operation = Operation::integer_power, .of = {a, -1, -1}, .index = exponent});
}

Term Graph::power(Term a, Term b) {
  constexpr double max_exponent = 1024;  // of repeated multiplication
  if (is_constant(b)) {
    const double exponent = (*this)[b].value;
    if (exponent == std::floor(exponent) && std::abs(exponent) <= max_exponent)
      return integer_power(a, static_cast<int>(exponent));
    if (exponent == 0.5) return function(Operation::sqrt, a);
  }
  return made({.operation = Operation::power, .of = {a, b, -1}});
}

Term Graph::choose(Term g, Term a, Term b) {
  if (a == b) return a;
  if (is_constant(g)) return (*this)[g].value > 0 ? a : b;
  return stored({.operation = Operation::choose, .of = {g, a, b}});
}

Term Graph::look_up(const std::shared_ptr<const Table>& table, Term x, Term y, Table::Orders derivatives) {
  if (std::ranges::any_of(derivatives, [](int order) { return order > Table::max_derivative; })) return constant(0);
  const bool is_constant_y = y < 0 || is_constant(y);
  if (is_constant(x) && is_constant_y) {
    const double of[] = {(*this)[x].value, y < 0 ? 0 : (*this)[y].value};
    return constant(looked_up(*table, derivatives, of));
  }
  const Lookup made{table, derivatives};
  const auto known = std::ranges::find(lookups_, made);
  const auto index = static_cast<int>(known - lookups_.begin());
  if (known == lookups_.end()) lookups_.push_back(made);
  return stored({.operation = Operation::lookup, .of = {x, y, -1}, .index = index});
}

std::optional<std::pair<double, double>> Graph::affine(Term term, int variable) const {
  struct Line {
    double rate = NAN, value = NAN;  // NaN: it is none
  };
  const std::vector<bool> parts = parts_of({&term, 1});
  std::vector<Line> lines(parts.size());
  const auto line = [&](Term of) { return of < 0 ? Line() : lines[static_cast<std::size_t>(of)]; };
  for (Term at = 0; at <= term; ++at) {
    if (!parts[static_cast<std::size_t>(at)]) continue;
    const Node& node = (*this)[at];
    const Line a = line(node.of[0]);
    const Line b = line(node.of[1]);
    Line& out = lines[static_cast<std::size_t>(at)];
    switch (node.operation) {
      case Operation::constant:
        out = {0, node.value};
        break;
      case Operation::variable:
        if (node.index == variable) out = {1, 0};
        break;
      case Operation::add:
        out = {a.rate + b.rate, a.value + b.value};
        break;
      case Operation::subtract:
        out = {a.rate - b.rate, a.value - b.value};
        break;
      case Operation::negate:
        out = {-a.rate, -a.value};
        break;
      case Operation::multiply:
        if (a.rate == 0) out = {a.value * b.rate, a.value * b.value};
        if (b.rate == 0) out = {b.value * a.rate, b.value * a.value};
        break;
      case Operation::divide:
        if (b.rate == 0) out = {a.rate / b.value, a.value / b.value};
        break;
      default:
        break;
    }
  }
  const Line& out = lines[static_cast<std::size_t>(term)];
  if (!std::isfinite(out.rate) || !std::isfinite(out.value)) return std::nullopt;
  return std::pair(out.rate, out.value);
}

Term Graph::function(Operation operation, Term a, Term b) { return made({.operation = operation, .of = {a, b, -1}}); }

// Operands precede, so that no recursion is needed, however deep the graph is.
std::vector<bool> Graph::parts_of(std::span<const Term> terms) const {
  std::vector<bool> out(nodes_.size(), false);
  for (const Term term : terms) out[static_cast<std::size_t>(term)] = true;
  for (Term at = size() - 1; at >= 0; --at) {
    if (!out[static_cast<std::size_t>(at)]) continue;
    for (const Term operand : (*this)[at].of) {
      if (operand >= 0) out[static_cast<std::size_t>(operand)] = true;
    }
  }
  return out;
}

template <class Predicate>
bool Graph::any(Term term, Predicate predicate) const {
  const std::vector<bool> parts = parts_of({&term, 1});
  for (Term at = 0; at <= term; ++at) {
    if (parts[static_cast<std::size_t>(at)] && predicate((*this)[at])) return true;
  }
  return false;
}

bool Graph::depends_on(Term term, int variable) const {
  return any(term, [&](const Node& node) { return node.operation == Operation::variable && node.index == variable; });
}

bool Graph::has_choices(Term term) const {
  return any(term, [](const Node& node) { return node.operation == Operation::choose; });
}

}  // namespace gelenk::expression
