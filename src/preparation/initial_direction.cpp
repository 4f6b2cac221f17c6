// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/initial_direction.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

std::vector<double> without_inputs(const Inputs& inputs, std::size_t states, double time) {
  std::vector<double> out(inputs.signals(), 0.0);
  if (inputs.has_clock()) out.back() = time;
  out.resize(out.size() + states, 0.0);
  return out;
}

std::vector<double> initial_direction(const Assembled& start, Dynamics& of, const double* u) {
  const auto moves = [](const std::vector<double>& v) {
    return std::ranges::any_of(v, [](double x) { return std::abs(x) > 1e-9; });
  };
  if (moves(start.v)) return start.v;
  std::vector<double> vdot(start.v.size());
  of.set_position(start.q.data());
  of.factorize();
  of.set_velocity(start.v.data());
  of.solve(u, vdot.data());
  return moves(vdot) ? vdot : std::vector<double>();
}

}  // namespace gelenk
