// SPDX-License-Identifier: BSD-3-Clause
#include "batch/step_programs.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <set>

#include "batch/numbers.h"
#include "recorded/motion_terms.h"

namespace gelenk {
namespace {

using expression::Graph;
using expression::Node;
using expression::Operation;
using expression::Term;

Terms joined(Terms a, const Terms& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Sines and cosines that are parts of a and of b.
Terms circular_in_both(const Graph& graph, const Terms& a, const Terms& b) {
  const std::vector<bool> in_a = graph.parts_of(a);
  const std::vector<bool> in_b = graph.parts_of(b);
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

// The terms of the equations, by what computes them.
struct StepTerms {
  StepTerms(const Graph& graph, const SceneEquations& equations, const Pivots& pivots);

  MotionTerms motion;
  Terms rates, Phi, rate;
  Terms constants;     // parts that depend on numbers of the scene alone
  Terms factors;       // those of the motion that are no constants
  Terms of_positions;  // parts of rate that do not depend on velocities
  Terms circular;      // sines and cosines in Phi and in the rates
};

StepTerms::StepTerms(const Graph& graph, const SceneEquations& equations, const Pivots& pivots)
    : motion(graph, {equations.v.size(), equations.M, equations.J, equations.gamma, equations.h}, pivots),
      rates(joined(joined(equations.qdot, motion.accelerations), equations.rates)),
      Phi(of_pivots(equations.Phi, pivots)),
      rate(of_pivots(equations.rate, pivots)),
      factors(motion.factors) {
  const auto is_number = [&](int index) { return index >= VariedNumbers::first_variable && !is_residual(index); };
  const Terms every = joined(joined(joined(rates, Phi), rate), motion.displacement);
  constants = independent_parts(graph, every, [&](int index) { return !is_number(index); });
  const auto is_constant = [&](Term term) { return std::ranges::binary_search(constants, term); };
  std::erase_if(factors, is_constant);
  const auto nq = static_cast<int>(equations.q.size());
  const auto nv = static_cast<int>(equations.v.size());
  of_positions = independent_parts(graph, rate, [&](int index) { return nq <= index && index < nq + nv; });
  std::erase_if(of_positions, is_constant);
  circular = circular_in_both(graph, rates, Phi);
}

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
  const StepTerms of(graph, equations, pivots);
  constants = static_cast<int>(of.constants.size());
  factors = static_cast<int>(of.factors.size());
  place();
  lanes::Slots known = variables(graph);
  give(of.constants, slots.constants, known);
  lanes::Slots of_numbers;
  for (int k = 0; k < varied; ++k)
    of_numbers.emplace(graph.variable(VariedNumbers::first_variable + k), slots.numbers + k);
  prepare = lanes::Program(graph, of_numbers, outputs(of.constants, slots.constants), frame);

  // Rates that are velocities need not be copied.
  std::vector<lanes::Output> evaluated;
  for (int k = 0; k < size(); ++k) {
    const Term term = of.rates[static_cast<std::size_t>(k)];
    const Node& node = graph[term];
    const bool is_velocity =
        k < nq && node.operation == Operation::variable && nq <= node.index && node.index < nq + nv;
    rate_slots.push_back(is_velocity ? slots.y + node.index : slots.rates + k);
    rates_are_velocities = rates_are_velocities && (k >= nq || (nq == nv && rate_slots.back() == slots.y + nq + k));
    if (!is_velocity) evaluated.emplace_back(term, slots.rates + k);
  }
  std::ranges::copy(outputs(of.factors, slots.factors), std::back_inserter(evaluated));
  evaluate = lanes::Program(graph, known, evaluated, frame);

  if (rows > 0) compile_closing(graph, of, known, evaluated);
  if (!rates_are_velocities) {
    lanes::Slots by_displacement = known;
    for (int k = 0; k < nv; ++k) by_displacement[graph.variable(nq + k)] = slots.displacement + k;
    move = lanes::Program(graph, by_displacement, outputs(equations.qdot, slots.moved), frame);
  }
  for (std::size_t k = 0; k < equations.q.size(); ++k) {
    if (equations.q[k].name.ends_with(".Q[1]")) quaternions.push_back(static_cast<int>(k));
  }
  add_guards(of.factors, of.motion.reciprocal_pivots, false, pivots.rows);
  add_guards(of.factors, of.motion.reciprocal_masses, true, of.motion.free);
  for (lanes::Program* program : {&prepare, &evaluate, &evaluate_closed, &gaps, &gap_rates, &displace, &move})
    program->place_temporaries(frame);
}

// What closes constraint equations.
void StepPrograms::compile_closing(Graph& graph, const StepTerms& of, const lanes::Slots& known,
                                   const std::vector<lanes::Output>& evaluated) {
  const int positions = frame.add(static_cast<int>(of.of_positions.size()));
  const int circular = frame.add(static_cast<int>(of.circular.size()));
  std::vector<lanes::Output> gap = outputs(of.Phi, slots.Phi);
  std::ranges::copy(outputs(of.of_positions, positions), std::back_inserter(gap));
  std::ranges::copy(outputs(of.circular, circular), std::back_inserter(gap));
  gaps = lanes::Program(graph, known, gap, frame);
  lanes::Slots closed = known;
  give(of.circular, circular, closed);
  evaluate_closed = lanes::Program(graph, closed, evaluated, frame);
  lanes::Slots at_position = known;
  give(of.of_positions, positions, at_position);
  gap_rates = lanes::Program(graph, at_position, outputs(of.rate, slots.rate), frame);
  lanes::Slots of_factors;
  give(of.constants, slots.constants, of_factors);
  give(of.factors, slots.factors, of_factors);
  give(of.motion.residual, slots.Phi, of_factors);
  displace = lanes::Program(graph, of_factors, outputs(of.motion.displacement, slots.displacement), frame);
}

void StepPrograms::add_guards(const Terms& among, const Terms& reciprocals, bool is_mass, const std::vector<int>& by) {
  for (std::size_t k = 0; k < reciprocals.size(); ++k) {
    const auto found = std::ranges::find(among, reciprocals[k]);
    if (found != among.end())
      guards.push_back({slots.factors + static_cast<int>(found - among.begin()), is_mass, by[k]});
  }
}

void StepPrograms::place() {
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
}

// u are inputs, the time, element states.
lanes::Slots StepPrograms::variables(Graph& graph) const {
  lanes::Slots out;
  for (int k = 0; k < nq + nv; ++k) out.emplace(graph.variable(k), slots.y + k);
  int index = nq + nv;
  for (int k = 0; k < inputs; ++k) out.emplace(graph.variable(index++), slots.u + k);
  if (reads_time) out.emplace(graph.variable(index++), slots.time);
  for (int k = 0; k < states; ++k) out.emplace(graph.variable(index++), slots.y + nq + nv + k);
  return out;
}

}  // namespace gelenk
