// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/equation_program.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recorded/motion_terms.h"
#include "recorded/recorded_island.h"

namespace gelenk {
namespace {

using expression::Graph;
using expression::Term;
using recording::Recorded;
using Expressions = std::vector<Recorded>;

// Larger mechanisms are not recorded: the operations of an elimination without sparsity of the kernels' kind grow with
// the cube of the velocities.
constexpr int most_velocities = 40;
constexpr std::size_t most_links = 40;
// Instructions beyond which kernels are faster, as they keep to loops in the first cache.
constexpr std::size_t most_operations = 6000;

// Fractions of the usual size of pivots below which the kernels take over: at pivots of constraint equations that are
// small, errors grow, and accelerations in a singular configuration are not those of the equations
// (formulation/projection.cpp); masses, seen from a joint, vary a lot.
constexpr double least_constraint_pivot = 0.3;
constexpr double least_mass_pivot = 1e-8;

void add(const Terms& of, int first, std::vector<lanes::Output>& to) {
  for (const Term term : of) to.emplace_back(term, first++);
}

// Forces along cut joints, and what is named there, depend on their full turns, which change during a run.
bool depends_on_turns(const Loads& loads) {
  return std::ranges::any_of(loads.cuts, [](const JointLoads& on) { return !on.empty(); }) ||
         std::ranges::any_of(loads.named, [](const NamedQuantity& of) { return of.cut >= 0 || of.reading; });
}

}  // namespace

// The terms that a program computes.
struct ProgramTerms {
  ProgramTerms(const Graph& graph, const EquationTerms& of, const Pivots& pivots) : motion(graph, of, pivots) {}

  MotionTerms motion;
  Terms rates, reciprocal_distances;
};

bool EquationProgram::is_possible(const Mechanism& mechanism, const Loads& loads) {
  if (mechanism.nv == 0 || mechanism.nv > most_velocities || mechanism.links.size() > most_links) return false;
  if (mechanism.touches() || !loads.resets.empty() || loads.rates_read_forces() || loads.motions_follow_signals())
    return false;
  if (std::ranges::any_of(mechanism.coordinate_rows,
                          [](const CoordinateRow& row) { return row.relation || row.has_losses(); }))
    return false;
  return !depends_on_turns(loads);
}

std::unique_ptr<EquationProgram> EquationProgram::make(const Mechanism& mechanism, const Loads& loads,
                                                       const std::vector<double>& cut_reference, const Pivots& pivots) {
  if (!is_possible(mechanism, loads)) return nullptr;
  try {
    std::unique_ptr<EquationProgram> out(new EquationProgram(mechanism, loads, cut_reference, pivots));
    return out->evaluate_.empty() ? nullptr : std::move(out);
  } catch (const recording::HiddenBranch&) {
    return nullptr;
  }
}

EquationProgram::EquationProgram(const Mechanism& mechanism, const Loads& loads,
                                 const std::vector<double>& cut_reference, const Pivots& pivots)
    : pivots_(pivots), signals_(loads.first_named()), sides_(loads.tree.switching_count()), nv_(mechanism.nv) {
  const int nq = mechanism.nq;
  targets_ = 3 * static_cast<int>(mechanism.coordinate_rows.size());
  size_ = nq + nv_ + loads.states();
  Graph graph;
  const recording::Recording recording(graph);
  lanes::Frame frame;
  lanes::Slots known;
  int variable = 0;
  const auto place = [&](int count, Expressions& recorded) {
    const int first = frame.add(count);
    for (int k = 0; k < count; ++k) {
      const Recorded x = Recorded::variable(variable++);
      recorded.push_back(x);
      known.emplace(x.term(), first + k);
    }
    return first;
  };
  RecordedIsland island;
  y_ = place(nq, island.q);
  place(nv_, island.v);
  // Element states are read among the signals.
  frame.add(loads.states());
  u_ = place(signals_, island.signals);
  target_ = place(targets_, island.targets);
  side_ = place(sides_, island.sides);
  record(mechanism, loads, cut_reference, island);

  const Terms M = terms(island.M);
  const Terms J = terms(island.J);
  const Terms gamma = terms(island.gamma);
  const Terms h = terms(island.h);
  ProgramTerms of(graph, {static_cast<std::size_t>(nv_), M, J, gamma, h}, pivots_);
  for (const Terms& more : {terms(island.qdot), of.motion.accelerations, terms(island.rates)})
    of.rates.insert(of.rates.end(), more.begin(), more.end());
  for (const Recorded& distance : island.distances) of.reciprocal_distances.push_back((Recorded(1) / distance).term());
  add_varying(graph, of.reciprocal_distances, of.motion.factors);
  Terms all = of.rates;
  all.insert(all.end(), of.motion.factors.begin(), of.motion.factors.end());
  if (lanes::has_lookups(graph, all)) return;
  compile(of, graph, known, frame);
}

void EquationProgram::compile(const ProgramTerms& of, const Graph& graph, const lanes::Slots& known,
                              lanes::Frame& frame) {
  rate_ = frame.add(size_);
  residual_ = frame.add(static_cast<int>(of.motion.residual.size()));
  displacement_ = frame.add(nv_);
  const int first_factor = frame.add(static_cast<int>(of.motion.factors.size()));
  std::vector<lanes::Output> evaluated;
  add(of.rates, rate_, evaluated);
  add(of.motion.factors, first_factor, evaluated);
  lanes::Program evaluate(graph, known, evaluated, frame, lanes::Order::calls_first);
  lanes::Slots of_factors;
  for (std::size_t k = 0; k < of.motion.factors.size(); ++k)
    of_factors.emplace(of.motion.factors[k], first_factor + static_cast<int>(k));
  for (std::size_t k = 0; k < of.motion.residual.size(); ++k)
    of_factors.emplace(of.motion.residual[k], residual_ + static_cast<int>(k));
  std::vector<lanes::Output> displaced;
  add(of.motion.displacement, displacement_, displaced);
  lanes::Program displace(graph, of_factors, displaced, frame, lanes::Order::calls_first);
  if (evaluate.instructions().size() > most_operations) return;

  evaluate.place_temporaries(frame);
  displace.place_temporaries(frame);
  memory_.resize(static_cast<std::size_t>(frame.size()));
  for (const auto& [slot, value] : frame.constants()) memory_[static_cast<std::size_t>(slot)] = value;
  const auto guard = [&](const Terms& reciprocals, Guard::Of kind) {
    for (const Term term : reciprocals) {
      const auto found = std::ranges::find(of.motion.factors, term);
      if (found == of.motion.factors.end()) continue;
      guards_.push_back({first_factor + static_cast<int>(found - of.motion.factors.begin()), kind});
    }
  };
  guard(of.motion.reciprocal_pivots, Guard::Of::constraint);
  guard(of.motion.reciprocal_masses, Guard::Of::mass);
  guard(of.reciprocal_distances, Guard::Of::distance);
  limits_.assign(guards_.size(), 0);
  evaluate_ = machine_code::CompiledProgram(evaluate.instructions(), frame.fixed());
  displace_ = machine_code::CompiledProgram(displace.instructions(), frame.fixed());
}

bool EquationProgram::evaluate(const Arguments& given, double* ydot) {
  std::copy_n(given.y, size_, at(y_));
  std::copy_n(given.u, signals_, at(u_));
  std::copy_n(given.targets, targets_, at(target_));
  for (int i = 0; i < sides_; ++i) *at(side_ + i) = given.sides[i] == 1 || given.sides[i] == -1 ? given.sides[i] : 0;
  evaluate_.run(memory_.data());
  bool is_regular = true;
  double smallest = 1 / least_constraint_pivot;
  for (std::size_t k = 0; k < guards_.size(); ++k) {
    const double reciprocal = std::abs(*at(guards_[k].slot));
    is_regular = reciprocal <= limits_[k] && is_regular;
    if (guards_[k].of == Guard::Of::constraint && reciprocal * smallest > limits_[k])
      smallest = limits_[k] / reciprocal;
  }
  if (!is_regular) return false;
  pivot_fraction_ = least_constraint_pivot * smallest;
  std::copy_n(at(rate_), size_, ydot);
  return true;
}

double EquationProgram::largest_reciprocal(Guard::Of of, double usual) {
  switch (of) {
    case Guard::Of::constraint:
      return usual / least_constraint_pivot;
    case Guard::Of::mass:
      return usual / least_mass_pivot;
    default:
      return 1;
  }
}

bool EquationProgram::take_usual_pivots() {
  for (std::size_t k = 0; k < guards_.size(); ++k)
    limits_[k] = largest_reciprocal(guards_[k].of, std::abs(*at(guards_[k].slot)));
  return std::ranges::all_of(limits_, [](double limit) { return std::isfinite(limit); });
}

void EquationProgram::displace(const double* residual, double* dv) {
  for (std::size_t i = 0; i < pivots_.rows.size(); ++i)
    *at(residual_ + static_cast<int>(i)) = residual[pivots_.rows[i]];
  displace_.run(memory_.data());
  std::copy_n(at(displacement_), nv_, dv);
}

}  // namespace gelenk
