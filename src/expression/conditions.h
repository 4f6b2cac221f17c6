// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "expression/graph.h"

namespace gelenk::expression {

// Conditions of `if`, which become choices between terms: each comparison decides on a branch of its own.
class Conditions {
 public:
  explicit Conditions(Graph& graph) : graph_(graph) {}

  int positive(Term g) { return added({Kind::positive, g, -1}); }
  int negation(int a) { return added({Kind::negation, a, -1}); }
  int both(int a, int b) { return added({Kind::both, a, b}); }
  int either(int a, int b) { return added({Kind::either, a, b}); }

  // first where the condition holds, else second.
  Term choose(int condition, Term first, Term second) {
    const Condition of = all_[static_cast<std::size_t>(condition)];
    switch (of.kind) {
      case Kind::positive:
        return graph_.choose(of.a, first, second);
      case Kind::negation:
        return choose(of.a, second, first);
      case Kind::both:
        return choose(of.a, choose(of.b, first, second), second);
      default:
        return choose(of.a, first, choose(of.b, first, second));
    }
  }

 private:
  enum class Kind { positive, negation, both, either };
  struct Condition {
    Kind kind = Kind::positive;
    int a = -1, b = -1;  // a term, or conditions
  };
  int added(Condition condition) {
    all_.push_back(condition);
    return static_cast<int>(all_.size()) - 1;
  }

  Graph& graph_;
  std::vector<Condition> all_;
};

}  // namespace gelenk::expression
