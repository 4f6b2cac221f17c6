// SPDX-License-Identifier: BSD-3-Clause
#include "lanes/program.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

namespace gelenk::lanes {
namespace {

using expression::Graph;
using expression::Node;
using expression::Operation;
using expression::Term;

// Temporary slots, until their number is known.
constexpr int first_temporary = 1 << 24;

// Translates terms to instructions on numbered values, which then get slots.
class Compiler {
 public:
  Compiler(const Graph& graph, const Slots& given, const std::vector<Output>& outputs, Frame& frame, Order order)
      : graph_(graph), frame_(frame), value_of_(static_cast<std::size_t>(graph.size()), -1), uses_(value_of_.size()) {
    for (const auto& [term, slot] : given) value_of_[static_cast<std::size_t>(term)] = fixed(slot);
    count_uses(outputs);
    for (const auto& [term, slot] : outputs) translate(term);
    for (const auto& [term, slot] : outputs) put(term, slot);
    order == Order::alike ? gather() : advance_calls();
  }

  std::vector<Instruction> allocated();

 private:
  struct Product {
    bool is_scaled = false;
    double k = 0;
    Term a = -1, b = -1;
  };

  int& value(Term term) { return value_of_[static_cast<std::size_t>(term)]; }
  bool is_known(Term term) { return value(term) >= 0 || graph_.is_constant(term); }
  int fixed(int slot) {
    slots_.push_back(slot);
    return static_cast<int>(slots_.size()) - 1;
  }
  int fresh() { return fixed(-1); }
  // The value of a term that has been translated.
  int of(Term term) {
    if (value(term) < 0) value(term) = fixed(frame_.constant(graph_[term].value));
    return value(term);
  }
  int emit(Instruction instruction) {
    if (instruction.to < 0) instruction.to = fresh();
    code_.push_back(instruction);
    return instruction.to;
  }

  void count_uses(const std::vector<Output>& outputs);
  void translate(Term term);
  template <class Do>
  void each_part(Term term, Do&& act);
  bool is_product(Term term) {
    return graph_[term].operation == Operation::multiply && !is_known(term) &&
           uses_[static_cast<std::size_t>(term)] == 1;
  }
  Product product(Term term) const;
  int computed(Term term);
  int sum(const Node& node);
  int plain_sum(const Node& node);
  int one_product(const Product& p, Term other, bool is_first, bool is_difference);
  int power(int x, int exponent);
  int circular(Term term);
  void put(Term term, int slot);
  void gather();
  void advance_calls();

  const Graph& graph_;
  Frame& frame_;
  std::vector<int> value_of_;  // by term; -1: not yet computed
  std::vector<int> uses_;
  std::map<Term, std::array<Term, 2>> circular_;  // by argument: sine and cosine
  std::vector<int> slots_;                        // by value; -1: not yet chosen
  std::vector<Instruction> code_;
};

void Compiler::count_uses(const std::vector<Output>& outputs) {
  std::vector<bool> is_live(value_of_.size(), false);
  for (const auto& [term, slot] : outputs) {
    ++uses_[static_cast<std::size_t>(term)];
    is_live[static_cast<std::size_t>(term)] = true;
  }
  for (Term term = graph_.size() - 1; term >= 0; --term) {
    if (!is_live[static_cast<std::size_t>(term)] || is_known(term)) continue;
    const Node& node = graph_[term];
    for (const Term operand : node.of) {
      if (operand < 0) continue;
      is_live[static_cast<std::size_t>(operand)] = true;
      ++uses_[static_cast<std::size_t>(operand)];
    }
    if (node.operation == Operation::sin || node.operation == Operation::cos) {
      const auto at = circular_.try_emplace(node.of[0], std::array<Term, 2>{-1, -1}).first;
      at->second[node.operation == Operation::cos ? 1 : 0] = term;
    }
  }
}

// What has to be translated before a term. A product that is used in one sum is a part of that.
template <class Do>
void Compiler::each_part(Term term, Do&& act) {
  const Node& node = graph_[term];
  for (const Term operand : node.of) {
    if (operand < 0) continue;
    if ((node.operation == Operation::add || node.operation == Operation::subtract) && is_product(operand)) {
      act(graph_[operand].of[0]);
      act(graph_[operand].of[1]);
    } else {
      act(operand);
    }
  }
}

// Depth first: what was computed last is used next.
void Compiler::translate(Term term) {
  std::vector<Term> waiting{term};
  while (!waiting.empty()) {
    const Term at = waiting.back();
    if (is_known(at)) {
      waiting.pop_back();
      continue;
    }
    const std::size_t before = waiting.size();
    each_part(at, [&](Term part) {
      if (!is_known(part)) waiting.push_back(part);
    });
    if (waiting.size() > before) continue;
    value(at) = computed(at);
    waiting.pop_back();
  }
}

Compiler::Product Compiler::product(Term term) const {
  const Node& node = graph_[term];
  for (const std::size_t k : {0U, 1U}) {
    if (graph_.is_constant(node.of[k])) return {true, graph_[node.of[k]].value, node.of[1 - k], -1};
  }
  return {false, 0, node.of[0], node.of[1]};
}

// p + other, p - other or other - p.
int Compiler::one_product(const Product& p, Term other, bool is_first, bool is_difference) {
  Code code = p.is_scaled ? Code::scale_add : Code::multiply_add;
  if (is_difference && is_first) code = p.is_scaled ? Code::scale_subtract : Code::multiply_subtract;
  if (is_difference && !is_first) code = p.is_scaled ? Code::subtract_scale : Code::subtract_multiply;
  return emit({.code = code, .to = -1, .a = of(p.a), .b = p.is_scaled ? -1 : of(p.b), .c = of(other), .k = p.k});
}

int Compiler::plain_sum(const Node& node) {
  const bool is_difference = node.operation == Operation::subtract;
  const auto [a, b, unused] = node.of;
  if (graph_.is_constant(b)) {
    const double k = graph_[b].value;
    return emit({.code = Code::add_constant, .to = -1, .a = of(a), .k = is_difference ? -k : k});
  }
  if (graph_.is_constant(a)) {
    const Code code = is_difference ? Code::subtract_from_constant : Code::add_constant;
    return emit({.code = code, .to = -1, .a = of(b), .k = graph_[a].value});
  }
  return emit({.code = is_difference ? Code::subtract : Code::add, .to = -1, .a = of(a), .b = of(b)});
}

int Compiler::sum(const Node& node) {
  const bool is_difference = node.operation == Operation::subtract;
  const auto [a, b, unused] = node.of;
  if (is_product(a) && is_product(b)) {
    const Product p = product(a);
    const Product r = product(b);
    if (!p.is_scaled && !r.is_scaled) {
      const Code code = is_difference ? Code::multiply_subtract_multiply : Code::multiply_add_multiply;
      return emit({.code = code, .to = -1, .a = of(p.a), .b = of(p.b), .c = of(r.a), .d = of(r.b)});
    }
    value(b) = computed(b);
  }
  if (is_product(a)) return one_product(product(a), b, true, is_difference);
  if (is_product(b)) return one_product(product(b), a, false, is_difference);
  return plain_sum(node);
}

// By repeated squaring, as expression::integer_power().
int Compiler::power(int x, int exponent) {
  int out = -1;
  for (int n = std::abs(exponent); n > 0; n /= 2) {
    if (n % 2 == 1) out = out < 0 ? x : emit({.code = Code::multiply, .to = -1, .a = out, .b = x});
    if (n > 1) x = emit({.code = Code::multiply, .to = -1, .a = x, .b = x});
  }
  return exponent < 0 ? emit({.code = Code::divide_constant, .to = -1, .a = out, .k = 1}) : out;
}

// Sine and cosine of one argument are computed together.
int Compiler::circular(Term term) {
  const Node& node = graph_[term];
  const auto [sine, cosine] = circular_.at(node.of[0]);
  const int x = of(node.of[0]);
  if (sine < 0 || cosine < 0 || is_known(sine) || is_known(cosine))
    return emit({.code = node.operation == Operation::sin ? Code::sine : Code::cosine, .to = -1, .a = x});
  const int of_cosine = fresh();
  const int of_sine = emit({.code = Code::sine_cosine, .to = -1, .a = x, .b = of_cosine});
  value(sine) = of_sine;
  value(cosine) = of_cosine;
  return value(term);
}

int Compiler::computed(Term term) {
  const Node& node = graph_[term];
  const auto [a, b, c] = node.of;
  switch (node.operation) {
    case Operation::add:
    case Operation::subtract:
      return sum(node);
    case Operation::multiply: {
      const Product p = product(term);
      if (p.is_scaled) return emit({.code = Code::scale, .to = -1, .a = of(p.a), .k = p.k});
      return emit({.code = Code::multiply, .to = -1, .a = of(a), .b = of(b)});
    }
    case Operation::divide:
      if (graph_.is_constant(a))
        return emit({.code = Code::divide_constant, .to = -1, .a = of(b), .k = graph_[a].value});
      return emit({.code = Code::divide, .to = -1, .a = of(a), .b = of(b)});
    case Operation::negate:
      return emit({.code = Code::negate, .to = -1, .a = of(a)});
    case Operation::integer_power:
      return power(of(a), node.index);
    case Operation::sin:
    case Operation::cos:
      return circular(term);
    case Operation::sqrt:
      return emit({.code = Code::square_root, .to = -1, .a = of(a)});
    case Operation::choose:
      return emit({.code = Code::choose, .to = -1, .a = of(a), .b = of(b), .c = of(c)});
    default:
      return emit({.code = Code::function, .function = node.operation, .to = -1, .a = of(a), .b = b < 0 ? -1 : of(b)});
  }
}

// A value that has no slot yet is computed into that of the output.
void Compiler::put(Term term, int slot) {
  int& place = slots_[static_cast<std::size_t>(of(term))];
  if (place < 0) {
    place = slot;
  } else if (place != slot) {
    emit({.code = Code::copy, .to = fixed(slot), .a = of(term)});
  }
}

// In another order, with more instructions of the same kind one after the other, so that there are fewer branches
// that processors cannot predict. Only what comes soon anyway is taken, so that values are not kept long.
void Compiler::gather() {
  constexpr std::size_t horizon = 48;
  std::vector<std::size_t> writer(slots_.size(), code_.size());
  std::vector<int> waiting(code_.size(), 0);  // by instruction: of how many it needs results
  std::vector<std::vector<std::size_t>> next(code_.size());
  for (std::size_t k = 0; k < code_.size(); ++k) {
    each_operand(code_[k], [&](int& x) {
      const std::size_t before = writer[static_cast<std::size_t>(x)];
      if (before == code_.size()) return;
      next[before].push_back(k);
      ++waiting[k];
    });
    writer[static_cast<std::size_t>(code_[k].to)] = k;
    if (code_[k].code == Code::sine_cosine) writer[static_cast<std::size_t>(code_[k].b)] = k;
  }
  std::vector<Instruction> out;
  std::vector<bool> is_done(code_.size(), false);
  std::size_t first = 0;
  Code last = Code::copy;
  while (out.size() < code_.size()) {
    while (is_done[first]) ++first;
    std::size_t chosen = first;
    for (std::size_t k = first; k < std::min(first + horizon, code_.size()); ++k) {
      if (is_done[k] || waiting[k] > 0 || code_[k].code != last) continue;
      chosen = k;
      break;
    }
    is_done[chosen] = true;
    for (const std::size_t k : next[chosen]) --waiting[k];
    last = code_[chosen].code;
    out.push_back(code_[chosen]);
  }
  code_ = std::move(out);
}

// In another order: what calls a function as soon as its arguments are known, and together.
void Compiler::advance_calls() {
  std::vector<int> ready(slots_.size(), 0);  // by value: after how many rounds of calls it is known
  std::vector<int> key(code_.size());
  for (std::size_t k = 0; k < code_.size(); ++k) {
    int round = 0;
    each_operand(code_[k], [&](int& x) { round = std::max(round, ready[static_cast<std::size_t>(x)]); });
    const bool calls = calls_function(code_[k].code);
    key[k] = 2 * round + (calls ? 1 : 0);
    ready[static_cast<std::size_t>(code_[k].to)] = round + (calls ? 1 : 0);
    if (code_[k].code == Code::sine_cosine) ready[static_cast<std::size_t>(code_[k].b)] = round + 1;
  }
  std::vector<std::size_t> order(code_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return key[k]; });
  std::vector<Instruction> out;
  for (const std::size_t k : order) out.push_back(code_[k]);
  code_ = std::move(out);
}

// Temporary slots are used again after the last use of their values, but not for the result of the same instruction:
// the kernels may then assume that what they write is not what they read.
std::vector<Instruction> Compiler::allocated() {
  std::vector<std::size_t> last(slots_.size(), 0);
  for (std::size_t k = 0; k < code_.size(); ++k)
    each_operand(code_[k], [&](int& x) { last[static_cast<std::size_t>(x)] = k; });
  std::vector<int> free;
  std::vector<int> freed;
  int count = 0;
  const auto place = [&](int& x) {
    int& slot = slots_[static_cast<std::size_t>(x)];
    if (slot < 0) {
      if (free.empty()) free.push_back(first_temporary + count++);
      slot = free.back();
      free.pop_back();
    }
    x = slot;
  };
  for (std::size_t k = 0; k < code_.size(); ++k) {
    Instruction& i = code_[k];
    freed.clear();
    each_operand(i, [&](int& x) {
      const auto at = static_cast<std::size_t>(x);
      const int slot = slots_[at];
      if (slot >= first_temporary && last[at] == k && std::ranges::find(freed, slot) == freed.end())
        freed.push_back(slot);
      x = slot;
    });
    place(i.to);
    if (i.code == Code::sine_cosine) place(i.b);
    free.insert(free.end(), freed.begin(), freed.end());
  }
  frame_.need_temporaries(count);
  return code_;
}

}  // namespace

bool has_lookups(const Graph& graph, const std::vector<Term>& terms) {
  const std::vector<bool> parts = graph.parts_of(terms);
  for (Term term = 0; term < graph.size(); ++term) {
    if (parts[static_cast<std::size_t>(term)] && graph[term].operation == Operation::lookup) return true;
  }
  return false;
}

Program::Program(const Graph& graph, const Slots& given, const std::vector<Output>& outputs, Frame& frame, Order order)
    : instructions_(Compiler(graph, given, outputs, frame, order).allocated()) {}

void Program::place_temporaries(const Frame& frame) {
  const auto place = [&](int& slot) {
    if (slot >= first_temporary) slot += frame.fixed() - first_temporary;
  };
  for (Instruction& i : instructions_) {
    place(i.to);
    for (int Instruction::* const operand : {&Instruction::a, &Instruction::b, &Instruction::c, &Instruction::d})
      place(i.*operand);
  }
}

}  // namespace gelenk::lanes
