// SPDX-License-Identifier: BSD-3-Clause
#include "batch/step_programs.h"

#include <algorithm>
#include <functional>
#include <set>

#include "batch/numbers.h"

namespace gelenk {
namespace {

using expression::Graph;
using expression::Node;
using expression::Operation;
using expression::Term;
using recording::Recorded;
using Terms = std::vector<Term>;

// Indices of variables of which no one is an argument: residuals that a displacement removes.
constexpr int first_residual = 1 << 21;

Terms terms(const Elimination::Numbers& of) {
  Terms out;
  for (const Recorded& x : of) out.push_back(x.term());
  return out;
}

Terms joined(Terms a, const Terms& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// The largest parts of terms that depend on none of the variables for which `depends` holds, and are no constants.
Terms independent_parts(const Graph& graph, const Terms& of, const std::function<bool(int)>& depends) {
  std::vector<bool> varies(static_cast<std::size_t>(graph.size()), false);
  for (Term term = 0; term < graph.size(); ++term) {
    const Node& node = graph[term];
    const auto at = static_cast<std::size_t>(term);
    varies[at] = node.operation == Operation::variable && depends(node.index);
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

std::vector<bool> parts_of(const Graph& graph, const Terms& of) {
  std::vector<bool> out(static_cast<std::size_t>(graph.size()), false);
  for (const Term term : of) out[static_cast<std::size_t>(term)] = true;
  for (Term term = graph.size() - 1; term >= 0; --term) {
    if (!out[static_cast<std::size_t>(term)]) continue;
    for (const Term operand : graph[term].of) {
      if (operand >= 0) out[static_cast<std::size_t>(operand)] = true;
    }
  }
  return out;
}

// Sines and cosines that are parts of a and of b.
Terms circular_in_both(const Graph& graph, const Terms& a, const Terms& b) {
  const std::vector<bool> in_a = parts_of(graph, a);
  const std::vector<bool> in_b = parts_of(graph, b);
  Terms out;
  for (Term term = 0; term < graph.size(); ++term) {
    const Operation operation = graph[term].operation;
    if ((operation == Operation::sin || operation == Operation::cos) && in_a[static_cast<std::size_t>(term)] &&
        in_b[static_cast<std::size_t>(term)])
      out.push_back(term);
  }
  return out;
}

std::vector<lanes::Output> outputs(const Terms& of, int first) {
  std::vector<lanes::Output> out;
  for (const Term term : of) out.emplace_back(term, first++);
  return out;
}

void give(const Terms& of, int first, lanes::Slots& given) {
  for (const Term term : of) given.emplace(term, first++);
}

}  // namespace

StepPrograms::StepPrograms(const SceneEquations& equations, const Pivots& pivots, int varied_numbers)
    : nq(static_cast<int>(equations.q.size())),
      nv(static_cast<int>(equations.v.size())),
      states(static_cast<int>(equations.states.size())),
      inputs(equations.inputs),
      rows(static_cast<int>(pivots.rows.size())),
      varied(varied_numbers),
      reads_time(equations.reads_time) {
  Graph graph = equations.graph;
  const recording::Recording recording(graph);
  const Elimination elimination(equations, pivots);
  const auto of_rows = [&](const Terms& all) {
    Elimination::Numbers out;
    for (const int row : pivots.rows) out.push_back(Recorded::of(all[static_cast<std::size_t>(row)]));
    return out;
  };
  Elimination::Numbers h;
  for (const Term term : equations.h) h.push_back(Recorded::of(term));
  const Terms rates =
      joined(joined(equations.qdot, terms(elimination.accelerations(of_rows(equations.gamma), h))), equations.rates);
  const Terms Phi = terms(of_rows(equations.Phi));
  const Terms rate = terms(of_rows(equations.rate));
  Elimination::Numbers residual;
  for (int i = 0; i < rows; ++i) residual.push_back(Recorded::variable(first_residual + i));
  const Terms displacement = terms(elimination.displacement(residual));

  // What is computed when.
  Terms every = joined(joined(joined(rates, Phi), rate), displacement);
  const Terms prepared = independent_parts(
      graph, every, [](int index) { return index < VariedNumbers::first_variable || index >= first_residual; });
  const auto is_prepared = [&](Term term) { return std::ranges::binary_search(prepared, term); };
  const auto without_prepared = [&](Terms of) {
    std::erase_if(of, is_prepared);
    return of;
  };
  Terms needed = independent_parts(graph, displacement, [](int index) { return index >= first_residual; });
  for (const Elimination::Numbers* pivot : {&elimination.reciprocal_pivots(), &elimination.reciprocal_masses()}) {
    for (const Term term : terms(*pivot)) {
      if (!graph.is_constant(term) && std::ranges::find(needed, term) == needed.end()) needed.push_back(term);
    }
  }
  needed = without_prepared(needed);
  const Terms of_positions =
      without_prepared(independent_parts(graph, rate, [&](int index) { return nq <= index && index < nq + nv; }));
  constants = static_cast<int>(prepared.size());
  factors = static_cast<int>(needed.size());

  slots.y = frame.add(size());
  slots.rates = frame.add(size());
  slots.before = frame.add(size());
  slots.sum = frame.add(size());
  slots.u = frame.add(inputs);
  slots.time = frame.add(1);
  slots.Phi = frame.add(rows);
  slots.rate = frame.add(rows);
  slots.displacement = frame.add(nv);
  slots.moved = frame.add(nq);
  slots.numbers = frame.add(varied);
  slots.constants = frame.add(constants);
  slots.factors = frame.add(factors);
  const int gap_parts = frame.add(static_cast<int>(of_positions.size()));
  const Terms circular = circular_in_both(graph, rates, Phi);
  const int circular_slots = frame.add(static_cast<int>(circular.size()));

  // Where variables are; u are inputs, the time, element states.
  lanes::Slots given;
  for (int k = 0; k < nq + nv; ++k) given.emplace(graph.variable(k), slots.y + k);
  int index = nq + nv;
  for (int k = 0; k < inputs; ++k) given.emplace(graph.variable(index++), slots.u + k);
  if (reads_time) given.emplace(graph.variable(index++), slots.time);
  for (int k = 0; k < states; ++k) given.emplace(graph.variable(index++), slots.y + nq + nv + k);
  lanes::Slots of_numbers;
  for (int k = 0; k < varied; ++k)
    of_numbers.emplace(graph.variable(VariedNumbers::first_variable + k), slots.numbers + k);
  prepare = lanes::Program(graph, of_numbers, outputs(prepared, slots.constants), frame);
  give(prepared, slots.constants, given);
  // Rates that are velocities need not be copied.
  std::vector<lanes::Output> evaluated;
  for (int k = 0; k < size(); ++k) {
    const Term term = rates[static_cast<std::size_t>(k)];
    const bool is_velocity = k < nq && graph[term].operation == Operation::variable && nq <= graph[term].index &&
                             graph[term].index < nq + nv;
    rate_slots.push_back(is_velocity ? slots.y + graph[term].index : slots.rates + k);
    if (!is_velocity) evaluated.emplace_back(term, slots.rates + k);
  }
  for (const lanes::Output& output : outputs(needed, slots.factors)) evaluated.push_back(output);
  evaluate = lanes::Program(graph, given, evaluated, frame);

  if (rows > 0) {
    std::vector<lanes::Output> gap = outputs(Phi, slots.Phi);
    for (const lanes::Output& output : outputs(of_positions, gap_parts)) gap.push_back(output);
    for (const lanes::Output& output : outputs(circular, circular_slots)) gap.push_back(output);
    gaps = lanes::Program(graph, given, gap, frame);
    lanes::Slots closed = given;
    give(circular, circular_slots, closed);
    evaluate_closed = lanes::Program(graph, closed, evaluated, frame);
    lanes::Slots at_position = given;
    give(of_positions, gap_parts, at_position);
    gap_rates = lanes::Program(graph, at_position, outputs(rate, slots.rate), frame);
    lanes::Slots of_factors;
    give(prepared, slots.constants, of_factors);
    give(needed, slots.factors, of_factors);
    for (int i = 0; i < rows; ++i) of_factors.emplace(graph.variable(first_residual + i), slots.Phi + i);
    displace = lanes::Program(graph, of_factors, outputs(displacement, slots.displacement), frame);
  }
  for (int k = 0; k < nq; ++k) {
    const Term term = equations.qdot[static_cast<std::size_t>(k)];
    if (nq == nv && term == graph.variable(nq + k)) continue;
    rates_are_velocities = false;
  }
  if (!rates_are_velocities) {
    lanes::Slots by_displacement;
    give(prepared, slots.constants, by_displacement);
    for (int k = 0; k < nq; ++k) by_displacement.emplace(graph.variable(k), slots.y + k);
    for (int k = 0; k < nv; ++k) by_displacement.emplace(graph.variable(nq + k), slots.displacement + k);
    move = lanes::Program(graph, by_displacement, outputs(equations.qdot, slots.moved), frame);
  }
  for (std::size_t k = 0; k + 3 < equations.q.size(); ++k) {
    if (equations.q[k].name.ends_with(".Q[1]")) quaternions.push_back(static_cast<int>(k));
  }

  const auto guard = [&](const Elimination::Numbers& reciprocals, bool is_mass, const std::vector<int>& of) {
    for (std::size_t k = 0; k < reciprocals.size(); ++k) {
      const auto found = std::ranges::find(needed, reciprocals[k].term());
      if (found != needed.end())
        guards.push_back({slots.factors + static_cast<int>(found - needed.begin()), is_mass, of[k]});
    }
  };
  guard(elimination.reciprocal_pivots(), false, pivots.rows);
  guard(elimination.reciprocal_masses(), true, elimination.free());
  for (lanes::Program* program : {&prepare, &evaluate, &evaluate_closed, &gaps, &gap_rates, &displace, &move})
    program->place_temporaries(frame);
}

}  // namespace gelenk
