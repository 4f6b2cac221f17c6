// SPDX-License-Identifier: BSD-3-Clause
#include "batch/equation_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "batch/numbers.h"
#include "expression/functions.h"

namespace gelenk {
namespace {

using expression::Operation;

std::vector<std::string> names(const std::vector<EquationArgument>& of) {
  std::vector<std::string> out;
  out.reserve(of.size());
  for (const EquationArgument& x : of) out.push_back(x.name);
  return out;
}

bool has_same_names(const SceneEquations& a, const SceneEquations& b) {
  return names(a.q) == names(b.q) && names(a.v) == names(b.v) && names(a.u) == names(b.u) && a.rows == b.rows;
}

// By term, from the variables below VariedNumbers::first_variable and those from it on.
std::vector<double> values_of(const expression::Graph& graph, const std::vector<double>& variables,
                              const std::vector<double>& numbers) {
  std::vector<double> out(static_cast<std::size_t>(graph.size()));
  for (int term = 0; term < graph.size(); ++term) {
    const expression::Node& node = graph[term];
    const auto of = [&](std::size_t k) { return out[static_cast<std::size_t>(node.of[k])]; };
    const auto value = [&] {
      switch (node.operation) {
        case Operation::constant:
          return node.value;
        case Operation::variable:
          return node.index < VariedNumbers::first_variable
                     ? variables[static_cast<std::size_t>(node.index)]
                     : numbers[static_cast<std::size_t>(node.index - VariedNumbers::first_variable)];
        case Operation::add:
          return of(0) + of(1);
        case Operation::subtract:
          return of(0) - of(1);
        case Operation::multiply:
          return of(0) * of(1);
        case Operation::divide:
          return of(0) / of(1);
        case Operation::negate:
          return -of(0);
        case Operation::integer_power:
          return expression::integer_power(of(0), node.index);
        case Operation::power:
          return expression::power(of(0), of(1));
        case Operation::choose:
          return of(0) > 0 ? of(1) : of(2);
        case Operation::atan2:
          return std::atan2(of(0), of(1));
        case Operation::lookup:
          return std::nan("");  // not recorded
        default:
          return expression::value_at(node.operation, of(0));
      }
    };
    out[static_cast<std::size_t>(term)] = value();
  }
  return out;
}

// Different by less than mistakes make, of the largest one, or undefined in both.
bool agree(const std::vector<double>& running, const std::vector<expression::Term>& recorded,
           const std::vector<double>& values) {
  constexpr double rounding = 1e-10;
  if (running.size() != recorded.size()) return false;
  double size = 0;
  for (const double x : running) size = std::isfinite(x) ? std::max(size, std::abs(x)) : size;
  for (std::size_t k = 0; k < running.size(); ++k) {
    const double here = values[static_cast<std::size_t>(recorded[k])];
    if (std::isfinite(running[k]) != std::isfinite(here)) return false;
    if (std::isfinite(here) && std::abs(here - running[k]) > rounding * size) return false;
  }
  return true;
}

// Different numbers of both signs and ordinary size.
double spread(std::size_t k) {
  return (k % 2 == 0 ? 0.1 : -0.1) * (1 + 0.37 * static_cast<double>(k % 5) + 0.11 * static_cast<double>(k % 7));
}

}  // namespace

bool are_equations_of(const TracedScene& scene, const SceneEquations& recorded, const std::vector<double>& numbers) {
  const SceneEquations& own = scene.equations();
  if (!has_same_names(own, recorded)) return false;
  std::vector<double> q;
  std::vector<double> v;
  std::vector<double> u;
  for (std::size_t k = 0; k < own.q.size(); ++k)
    q.push_back(own.q[k].start + spread(k) * (own.q[k].unit == "m" ? own.length : 1));
  for (std::size_t k = 0; k < own.v.size(); ++k) v.push_back(0.3 + 4 * spread(k + 1));
  for (std::size_t k = 0; k < own.u.size(); ++k) u.push_back(own.u[k].start + 3 * spread(k + 2));
  const EquationValues running = scene.values(q, v, u);
  std::vector<double> variables = q;
  variables.insert(variables.end(), v.begin(), v.end());
  variables.insert(variables.end(), u.begin(), u.end());
  const std::vector<double> values = values_of(recorded.graph, variables, numbers);
  return agree(running.M, recorded.M, values) && agree(running.J, recorded.J, values) &&
         agree(running.h, recorded.h, values) && agree(running.gamma, recorded.gamma, values) &&
         agree(running.Phi, recorded.Phi, values) && agree(running.rate, recorded.rate, values) &&
         agree(running.qdot, recorded.qdot, values) && agree(running.rates, recorded.rates, values);
}

}  // namespace gelenk
