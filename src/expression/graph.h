// SPDX-License-Identifier: BSD-3-Clause
// Expressions as a graph of operations on numbers. Equal subexpressions are one node, and what depends on constants
// alone is computed at once. Nodes refer to earlier ones only.
//
// The operations with kinks are `choose` and `lookup`: choose(g, a, b) is a where g > 0, else b, and a lookup is
// another polynomial beyond each point of its table. |x| is choose(x, x, -x), and so on; where a branch changes is thus
// known to whoever integrates the result.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "expression/table.h"

namespace gelenk::expression {

enum class Operation : unsigned char {
  constant,  // Node::value
  variable,  // Node::index
  add,
  subtract,
  multiply,
  divide,
  negate,
  integer_power,  // to Node::index
  power,          // of a positive base
  choose,
  lookup,  // in Graph::lookup(Node::index)
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  atan2,
  sinh,
  cosh,
  tanh,
  asinh,
  acosh,
  atanh,
  exp,
  log,
  log10,
  sqrt,
  cbrt,
  erf,
};

// Index of a node in its graph.
using Term = int;

struct Node {
  Operation operation = Operation::constant;
  std::array<Term, 3> of{-1, -1, -1};  // operands; -1: none
  int index = 0;                       // of a variable or a lookup; exponent
  double value = 0;                    // of a constant

  // Bit by bit, so that NaN equals itself.
  auto key() const { return std::tuple(operation, of, index, std::bit_cast<std::uint64_t>(value)); }
  bool operator==(const Node& other) const { return key() == other.key(); }
  struct Hash {
    std::size_t operator()(const Node& node) const {
      auto out = std::bit_cast<std::uint64_t>(node.value);
      for (const int part : {static_cast<int>(node.operation), node.of[0], node.of[1], node.of[2], node.index})
        out = (out ^ (out >> 29) ^ static_cast<std::uint32_t>(part)) * 0x9e3779b97f4a7c15U;
      return static_cast<std::size_t>(out ^ (out >> 32));
    }
  };
};

class Graph {
 public:
  Term constant(double x);
  Term variable(int index);

  Term add(Term a, Term b);
  Term subtract(Term a, Term b);
  Term multiply(Term a, Term b);
  Term divide(Term a, Term b);
  Term negate(Term a);
  // a to the power of b; if b is a constant integer, a may have any sign.
  Term power(Term a, Term b);
  Term integer_power(Term a, int exponent);
  Term choose(Term g, Term a, Term b);
  // A derivative of a table, as a function of its arguments; y: -1 if it has one argument.
  Term look_up(const std::shared_ptr<const Table>& table, Term x, Term y, Table::Orders derivatives = {});
  // A function of one argument, or atan2.
  Term function(Operation operation, Term a, Term b = -1);

  const Node& operator[](Term term) const { return nodes_[static_cast<std::size_t>(term)]; }
  int size() const { return static_cast<int>(nodes_.size()); }
  bool is_constant(Term term) const { return (*this)[term].operation == Operation::constant; }
  bool is_constant(Term term, double value) const { return is_constant(term) && (*this)[term].value == value; }
  // By term: whether it is a part of one of these.
  std::vector<bool> parts_of(std::span<const Term> terms) const;
  // Whether the term depends on a variable, and whether it has a kink at a choice.
  bool depends_on(Term term, int variable) const;
  bool has_choices(Term term) const;

  struct Lookup {
    std::shared_ptr<const Table> table;
    Table::Orders derivatives{};

    bool operator==(const Lookup&) const = default;
  };
  const Lookup& lookup(int index) const { return lookups_[static_cast<std::size_t>(index)]; }
  // a and b if the term is a*x + b for a variable x, as far as can be seen without multiplying out; {0, b}: a constant.
  std::optional<std::pair<double, double>> affine(Term term, int variable) const;

 private:
  // The node, or the one that is equal to it; a constant if its operands are constants.
  Term made(const Node& node);
  Term stored(const Node& node);
  Term& place_of(const Node& node);
  template <class Predicate>
  bool any(Term term, Predicate predicate) const;

  std::vector<Node> nodes_;
  // By the hashes of their nodes, with open addressing: terms; -1: none. Recording makes some ten thousand of them.
  std::vector<Term> known_;
  std::vector<Lookup> lookups_;
};

// The derivative of a term with respect to a variable, as a term. That of a choice is taken on its branch.
Term derivative(Graph& graph, Term term, int variable);

}  // namespace gelenk::expression
