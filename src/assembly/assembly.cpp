// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/assembly.h"

#include <algorithm>
#include <cmath>

#include "assembly/assembly_problem.h"
#include "assembly/conflict.h"
#include "assembly/loop_closure.h"
#include "assembly/nearest_assembly.h"
#include "linear/descent.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

// Relative to the largest pivot. If the loops close to rounding, coordinates at a singular configuration are known to
// its square root only, about 3e-8, and smaller pivots are zero. A velocity divided by one would be meaningless.
constexpr double singular_pivot_ratio = 1e-7;
constexpr double rounding_pivot_ratio = 1e-15;  // relative to the largest pivot: rounding

// Finds the joint with the largest closure error at the present position: gap [m], turn [rad], its index in worst.
void find_gap(const Mechanism& mechanism, const Dynamics& dynamics, double& gap, double& turn, int& worst) {
  gap = -1;
  turn = 0;
  const auto& Phi = dynamics.Phi();
  for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
    const Cut& cut = mechanism.cuts[c];
    double sum = 0;
    double angle = 0;
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      (dynamics.row_is_angle(r) ? angle : sum) += Phi[r] * Phi[r];
    }
    if (std::sqrt(sum) + std::sqrt(angle) <= gap + turn) continue;
    gap = std::sqrt(sum);
    turn = std::sqrt(angle);
    worst = c;
  }
  for (std::size_t i = 0; i < mechanism.coordinate_rows.size(); ++i) {
    const double error = std::abs(Phi[mechanism.first_coordinate_row() + static_cast<int>(i)]);
    if (error <= std::max(assembled_gap, gap + turn)) continue;
    const bool is_angle = mechanism.coordinate_rows[i].is_angle;
    gap = is_angle ? 0 : error;
    turn = is_angle ? error : 0;
    worst = static_cast<int>(mechanism.cuts.size() + i);
  }
  gap = std::max(0.0, gap);
}

// Closes all loops, group by group. Throws if that fails.
void close_groups(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem, const InitialGuess& tree,
                  const InitialGuess& cuts, Assembled& out) {
  out.q = tree.q;
  bool closed = true;
  const std::vector<LoopGroup> groups = loop_groups(mechanism);
  const LoopGroup* ambiguous = nullptr;
  for (const LoopGroup& group : groups) {
    NearestAssembly found = close_nearest(mechanism, dynamics, group, tree, cuts, out.q);
    closed = closed && found.closed;
    out.tries = std::max(out.tries, found.tries);
    if (found.equal_q.empty()) continue;
    out.equal_q = std::move(found.equal_q);
    ambiguous = &group;
  }
  // In the other assembly the other groups are as in this one.
  for (const Link& link : mechanism.links) {
    if (ambiguous == nullptr || link.nv == 0 || ambiguous->velocities[link.iv]) continue;
    std::copy_n(out.q.begin() + link.iq, link.nq, out.equal_q.begin() + link.iq);
  }
  if (closed) return;
  problem.gap(out.q);
  int worst = 0;
  double gap = 0;
  double turn = 0;
  find_gap(mechanism, dynamics, gap, turn, worst);
  throw CannotAssemble(gap, turn, worst, out.q, conflicting_positions(mechanism, dynamics, tree, cuts, out.q));
}

std::vector<double> consistent_velocities(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                          const InitialGuess& tree, const InitialGuess& cuts,
                                          const std::vector<double>& q) {
  AssemblyProblem::VelocityEquations s = problem.velocity_equations(q);
  const auto& free = problem.free(AssemblyProblem::Level::velocity);
  const auto n = static_cast<Eigen::Index>(free.size());
  double speed = 1;
  for (const double fixed : s.v) speed = std::max(speed, std::abs(fixed));
  double allowed = assembled_gap * speed * problem.length();
  const VectorXd v = nearest_velocities(s, singular_pivot_ratio);
  const VectorXd left = s.G.rows() > 0 ? VectorXd(s.G * v + s.g0) : VectorXd();
  // The part of the velocities that belongs to a pivot treated as zero cannot be satisfied and is meaningless.
  if (largest(left) > allowed &&
      RowSpace(s.G, singular_pivot_ratio).rank() < RowSpace(s.G, rounding_pivot_ratio).rank()) {
    allowed += singular_pivot_ratio * speed * s.G.coeffs().cwiseAbs().maxCoeff();
  }
  if (largest(left) > allowed) {
    throw CannotAssemble(largest(left), 0, -1, q,
                         conflicting_velocities(mechanism, dynamics, tree, cuts, q, allowed, singular_pivot_ratio));
  }
  for (Eigen::Index k = 0; k < n; ++k) s.v[free[static_cast<std::size_t>(k)]] = v[k];
  return s.v;
}

}  // namespace

Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts) {
  Assembled out;
  if (mechanism.rows == 0 && mechanism.cuts.empty()) {
    out.q = tree.q;
    out.v = tree.v;
    return out;
  }
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  close_groups(mechanism, dynamics, problem, tree, cuts, out);
  out.gap = largest(problem.gap(out.q)) / problem.length();
  out.moved = problem.moved(out.q).given;
  out.v = consistent_velocities(mechanism, dynamics, problem, tree, cuts, out.q);
  return out;
}

}  // namespace gelenk
