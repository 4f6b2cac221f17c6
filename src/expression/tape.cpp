// SPDX-License-Identifier: BSD-3-Clause
#include "expression/tape.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "util/text.h"

namespace gelenk::expression {
namespace {

// Slots of which those that are free again are used first.
class Slots {
 public:
  // Throws std::length_error if all are taken.
  short take() {
    if (free_.empty() && count_ == Tape::max_slots) {
      throw std::length_error("the expression needs more than " + std::to_string(Tape::max_slots) +
                              " intermediate values at once");
    }
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

// An operand that nothing else needs gives its place to the result.
void release_last_uses(const Node& node, Term at, const std::vector<Term>& last, const std::vector<short>& slot,
                       Slots& slots) {
  for (auto of = node.of.begin(); of != node.of.end(); ++of) {
    const bool is_first = std::find(node.of.begin(), of, *of) == of;
    if (*of >= 0 && is_first && last[static_cast<std::size_t>(*of)] == at)
      slots.release(slot[static_cast<std::size_t>(*of)]);
  }
}

}  // namespace

Tape::Tape(const Graph& graph, const std::vector<Term>& terms, int clock) {
  const std::vector<Term> last = last_uses(graph, terms);
  std::vector<short> slot(last.size(), -1);
  Slots slots;
  const auto is_loaded = [&](std::size_t at) {
    const Operation operation = graph[static_cast<Term>(at)].operation;
    return operation == Operation::variable || operation == Operation::constant;
  };
  // Variables and constants first: they are written before the instructions.
  for (std::size_t at = 0; at < last.size(); ++at) {
    if (last[at] < 0 || !is_loaded(at)) continue;
    const Node& node = graph[static_cast<Term>(at)];
    slot[at] = slots.take();
    if (node.operation == Operation::variable) {
      variables_.push_back({slot[at], node.index});
    } else {
      constants_.push_back({slot[at], node.value});
    }
  }
  for (std::size_t at = 0; at < last.size(); ++at) {
    if (last[at] < 0 || is_loaded(at)) continue;
    const Node& node = graph[static_cast<Term>(at)];
    Instruction made{.operation = node.operation, .index = node.index};
    for (std::size_t k = 0; k < node.of.size(); ++k) {
      if (node.of[k] >= 0) made.of[k] = slot[static_cast<std::size_t>(node.of[k])];
    }
    if (node.operation == Operation::choose) {
      made.index = choices_++;
      deciding_.push_back(node.of[0]);
    }
    if (node.operation == Operation::lookup) {
      made.index = static_cast<int>(lookups_.size());
      add_lookup(graph, node, clock);
    }
    release_last_uses(node, static_cast<Term>(at), last, slot, slots);
    made.to = slot[at] = slots.take();
    instructions_.push_back(made);
  }
  for (const Term term : terms) outputs_.push_back(slot[static_cast<std::size_t>(term)]);
  slots_ = slots.count();
}

void Tape::add_lookup(const Graph& graph, const Node& node, int clock) {
  Lookup& made = lookups_.emplace_back(Lookup{.of = graph.lookup(node.index)});
  const std::shared_ptr<const Table>& table = made.of.table;
  for (std::size_t k = 0; k < table->arguments(); ++k) {
    const auto line = graph.affine(node.of[k], clock);
    if (!line) {
      made.choices[k] = choices_;
      choices_ += static_cast<int>(table->axis(k).knots().size());
      deciding_.resize(static_cast<std::size_t>(choices_), node.of[k]);
    } else if (line->first != 0) {
      breaks_.push_back({table, k, line->first, line->second});
    }
  }
}

bool Tape::is_knot(int i) const {
  return std::ranges::any_of(lookups_, [&](const Lookup& lookup) {
    for (std::size_t k = 0; k < lookup.of.table->arguments(); ++k) {
      const int first = lookup.choices[k];
      if (first >= 0 && i >= first && i < first + static_cast<int>(lookup.of.table->axis(k).knots().size()))
        return true;
    }
    return false;
  });
}

std::string Tape::missing_value(const double* arguments, double t) const {
  const auto text_of = [](const Table& table, std::size_t axis, double x) {
    const std::vector<double>& points = table.axis(axis).points();
    return "the table " + table.data().name + " has no value at " + text::rounded(x) + ", but only from " +
           text::number(points.front()) + " to " + text::number(points.back()) + " (extrapolation: refuse)";
  };
  for (const Lookup& lookup : lookups_) {
    for (std::size_t k = 0; k < lookup.of.table->arguments(); ++k) {
      if (lookup.choices[k] < 0) continue;
      const double x = arguments[lookup.choices[k]] + lookup.of.table->axis(k).knots().front();
      if (lookup.of.table->refuses(k, x)) return text_of(*lookup.of.table, k, x);
    }
  }
  for (const Break& at : breaks_) {
    const double x = at.a * t + at.b;
    if (at.table->refuses(at.axis, x)) return text_of(*at.table, at.axis, x);
  }
  return {};
}

bool Tape::is_steady() const {
  return std::ranges::none_of(breaks_, [](const Break& at) {
    const Table& table = *at.table;
    if (table.data().interpolation == Interpolation::linear) return true;
    if (table.data().extrapolation[at.axis] != Extrapolation::hold) return false;
    const std::vector<double>& points = table.axis(at.axis).points();
    const auto last = static_cast<int>(points.size()) - 1;
    const bool ends_flat =
        table.at({points.front(), 0}, {1, 0}, {1, 0}) == 0 && table.at({points.back(), 0}, {last, 0}, {1, 0}) == 0;
    return table.arguments() > 1 || !ends_flat;
  });
}

double Tape::next_break(double t) const {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  double out = INFINITY;
  for (const Break& at : breaks_) {
    // At a knot within rounding, it is the next one that counts.
    const double margin = rounding * (std::abs(at.a * t) + std::abs(at.b));
    const double from = at.a * t + at.b + std::copysign(margin, at.a);
    const double knot = at.table->axis(at.axis).next_knot(from, at.a > 0);
    out = std::min(out, std::max((knot - at.b) / at.a, std::nextafter(t, INFINITY)));
  }
  return out;
}

template <class T>
void Tape::evaluate(const T* variables, T* out, const bool* held, T* arguments, const bool* periods) const {
  // Zeros in the unused rest of a large array would take longer than a short law.
  if (slots_ <= few_slots) return run<T, few_slots>(variables, out, held, arguments, periods);
  run<T, max_slots>(variables, out, held, arguments, periods);
}

template <class T, int size>
void Tape::run(const T* variables, T* out, const bool* held, T* arguments, const bool* periods) const {
  std::array<T, size> x;
  for (const auto& [slot, index] : variables_) x[static_cast<std::size_t>(slot)] = variables[index];
  for (const auto& [slot, value] : constants_) x[static_cast<std::size_t>(slot)] = T(value);
  const auto at = [&](const Instruction& i, int k) -> const T& {
    return x[static_cast<std::size_t>(i.of[static_cast<std::size_t>(k)])];
  };
  for (const Instruction& i : instructions_) {
    T& to = x[static_cast<std::size_t>(i.to)];
    switch (i.operation) {
      case Operation::add:
        to = at(i, 0) + at(i, 1);
        break;
      case Operation::subtract:
        to = at(i, 0) - at(i, 1);
        break;
      case Operation::multiply:
        to = at(i, 0) * at(i, 1);
        break;
      case Operation::divide:
        to = at(i, 0) / at(i, 1);
        break;
      case Operation::negate:
        to = -at(i, 0);
        break;
      case Operation::integer_power:
        to = integer_power(at(i, 0), i.index);
        break;
      case Operation::power:
        to = power(at(i, 0), at(i, 1));
        break;
      case Operation::atan2: {
        using std::atan2;
        to = atan2(at(i, 0), at(i, 1));
        break;
      }
      case Operation::choose: {
        if (arguments != nullptr) arguments[i.index] = at(i, 0);
        const bool first = held != nullptr ? held[i.index] : at(i, 0) > T(0);
        to = first ? at(i, 1) : at(i, 2);
        break;
      }
      case Operation::lookup: {
        const Lookup& lookup = lookups_[static_cast<std::size_t>(i.index)];
        const std::array<T, 2> of{at(i, 0), lookup.of.table->arguments() > 1 ? at(i, 1) : T(0)};
        to = looked_up(*lookup.of.table, lookup.of.derivatives, of.data(),
                       LookupBranches<T>{lookup.choices, held, held == nullptr ? periods : held, arguments});
        break;
      }
      default:
        to = applied(i.operation, at(i, 0));
    }
  }
  for (std::size_t k = 0; k < outputs_.size(); ++k) out[k] = x[static_cast<std::size_t>(outputs_[k])];
}

template void Tape::evaluate(const double*, double*, const bool*, double*, const bool*) const;
template void Tape::evaluate(const Dual*, Dual*, const bool*, Dual*, const bool*) const;
template void Tape::evaluate(const Series*, Series*, const bool*, Series*, const bool*) const;

}  // namespace gelenk::expression
