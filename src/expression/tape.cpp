// SPDX-License-Identifier: BSD-3-Clause
#include "expression/tape.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gelenk::expression {
namespace {

// Slots of which those that are free again are used first.
class Slots {
 public:
  short take() {
    if (free_.empty()) return static_cast<short>(count_++);
    const short slot = free_.back();
    free_.pop_back();
    return slot;
  }
  void release(short slot) { free_.push_back(slot); }
  int count() const { return count_; }

 private:
  std::vector<short> free_;
  int count_ = 0;
};

// By term, the last one that needs it; -1: none. Results are needed to the end.
std::vector<Term> last_uses(const Graph& graph, const std::vector<Term>& terms) {
  std::vector<Term> out(static_cast<std::size_t>(graph.size()), -1);
  for (const Term term : terms) out[static_cast<std::size_t>(term)] = graph.size();
  for (Term at = graph.size() - 1; at >= 0; --at) {
    if (out[static_cast<std::size_t>(at)] < 0) continue;
    for (const Term of : graph[at].of) {
      if (of >= 0) out[static_cast<std::size_t>(of)] = std::max(out[static_cast<std::size_t>(of)], at);
    }
  }
  return out;
}

}  // namespace

Tape::Tape(const Graph& graph, const std::vector<Term>& terms) {
  const std::vector<Term> last = last_uses(graph, terms);
  std::vector<short> slot(last.size(), -1);
  Slots slots;
  const auto limited = [&](short taken) {
    if (taken < max_slots) return taken;
    throw std::length_error("the expression needs more than " + std::to_string(max_slots) +
                            " intermediate values at once");
  };
  // Variables and constants first: they are written before the instructions.
  for (std::size_t at = 0; at < last.size(); ++at) {
    const Node& node = graph[static_cast<Term>(at)];
    if (last[at] < 0) continue;
    if (node.operation != Operation::variable && node.operation != Operation::constant) continue;
    slot[at] = limited(slots.take());
    if (node.operation == Operation::variable) {
      variables_.push_back({slot[at], node.index});
    } else {
      constants_.push_back({slot[at], node.value});
    }
  }
  for (std::size_t at = 0; at < last.size(); ++at) {
    const Node& node = graph[static_cast<Term>(at)];
    if (last[at] < 0 || slot[at] >= 0) continue;
    Instruction made{.operation = node.operation, .index = node.index};
    for (std::size_t k = 0; k < node.of.size(); ++k) {
      if (node.of[k] >= 0) made.of[k] = slot[static_cast<std::size_t>(node.of[k])];
    }
    if (node.operation == Operation::choose) {
      made.index = choices();
      choices_.push_back(node.of[0]);
    }
    // An operand that is not needed any more gives its place to the result.
    for (std::size_t k = 0; k < node.of.size(); ++k) {
      const auto of = static_cast<std::size_t>(node.of[k]);
      const bool repeated = std::find(node.of.begin(), node.of.begin() + static_cast<std::ptrdiff_t>(k), node.of[k]) !=
                            node.of.begin() + static_cast<std::ptrdiff_t>(k);
      if (node.of[k] >= 0 && !repeated && last[of] == static_cast<Term>(at)) slots.release(slot[of]);
    }
    made.to = slot[at] = limited(slots.take());
    instructions_.push_back(made);
  }
  for (const Term term : terms) outputs_.push_back(slot[static_cast<std::size_t>(term)]);
  slots_ = slots.count();
}

}  // namespace gelenk::expression
