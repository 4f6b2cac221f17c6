// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/assembly.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/assembly_problem.h"
#include "scene/text.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double closed = 1e-13;      // relative to the mechanism's length: some hundreds of roundings
constexpr double acceptable = 1e-9;   // m or rad: what the user is promised
constexpr double longest_step = 0.4;  // rad or m: farther than this the linearised loops say little
constexpr int most_tries = 24;        // starts before the loops are called impossible

double largest(const VectorXd& x) { return x.size() == 0 ? 0 : x.lpNorm<Eigen::Infinity>(); }

VectorXd limited(const VectorXd& step) {
  const double size = largest(step);
  return size > longest_step ? VectorXd(step * (longest_step / size)) : step;
}

// Closes the loops from q by Levenberg-Marquardt steps; returns the largest gap left.
double close(AssemblyProblem& problem, std::vector<double>& q) {
  VectorXd g = problem.gap(q);
  double damping = 0;
  for (int i = 0; i < 200 && largest(g) > closed * problem.length(); ++i) {
    const MatrixXd G = problem.gap_jacobian(q);
    if (G.cols() == 0) break;  // everything is fixed
    const double scale = G.squaredNorm() / std::max<Eigen::Index>(1, G.rows());
    bool better = false;
    for (int k = 0; k < 12 && !better; ++k) {
      VectorXd step;
      if (damping == 0) {
        step = -G.completeOrthogonalDecomposition().solve(g);
      } else {
        MatrixXd normal = G * G.transpose();
        normal.diagonal().array() += damping * scale;
        step = -G.transpose() * normal.ldlt().solve(g);
      }
      std::vector<double> next = problem.displaced(q, limited(step));
      const VectorXd g_next = problem.gap(next);
      better = g_next.norm() < g.norm() * (1 - 1e-6);
      if (better) {
        q = std::move(next);
        g = g_next;
        damping = damping < 1e-5 ? 0 : damping / 10;
      } else {
        damping = std::max(1e-4, damping * 8);
      }
    }
    if (!better) break;
  }
  return largest(g);
}

// An orthonormal basis of the free displacements that keep the loops closed.
MatrixXd nullspace(const MatrixXd& G, Eigen::Index n) {
  if (G.rows() == 0 || n == 0) return MatrixXd::Identity(n, n);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(G.transpose());
  qr.setThreshold(1e-9);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(n, n);
  return Q.rightCols(n - qr.rank());
}

// Moves along the closed loops towards the wishes.
void come_near(AssemblyProblem& problem, std::vector<double>& q) {
  double cost = problem.distance(q).squaredNorm();
  for (int i = 0; i < 100; ++i) {
    const auto n = static_cast<Eigen::Index>(problem.free(AssemblyProblem::Level::position).size());
    const MatrixXd Z = nullspace(problem.gap_jacobian(q), n);
    if (Z.cols() == 0) return;
    const MatrixXd T = problem.distance_jacobian(q) * Z;
    VectorXd step = limited(-(Z * T.completeOrthogonalDecomposition().solve(problem.distance(q))));
    bool better = false;
    for (int k = 0; k < 8 && !better; ++k, step /= 4) {
      if (largest(step) < 1e-13 * problem.length()) return;
      std::vector<double> next = problem.displaced(q, step);
      if (close(problem, next) > acceptable) continue;
      const double next_cost = problem.distance(next).squaredNorm();
      better = next_cost < cost;
      if (!better) continue;
      const bool done = cost - next_cost < 1e-14 * cost;
      q = std::move(next);
      cost = next_cost;
      if (done) return;
    }
    if (!better) return;
  }
}

// The wishes, their free coordinates shaken a little more with each try, always the same way.
std::vector<double> start_of_try(const AssemblyProblem& problem, const Wishes& tree, int attempt) {
  if (attempt == 0) return tree.q;
  std::mt19937 random(static_cast<unsigned>(attempt));
  // At first small, for guesses that stand on a dead point; in the end anywhere.
  const double reach = std::min(M_PI, 0.05 * std::pow(1.35, attempt));
  std::uniform_real_distribution<double> shake(-reach, reach);
  const auto n = static_cast<Eigen::Index>(problem.free(AssemblyProblem::Level::position).size());
  VectorXd step(n);
  for (Eigen::Index k = 0; k < n; ++k) step[k] = shake(random) * problem.length();
  return problem.displaced(tree.q, step);
}

std::string gap_text(const Mechanism& mechanism, const Dynamics& dynamics, int& worst) {
  double gap = -1;
  double turn = 0;
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
    const double off = std::abs(Phi[mechanism.first_coordinate_row() + static_cast<int>(i)]);
    if (off <= std::max(acceptable, gap + turn)) continue;
    const bool is_angle = mechanism.coordinate_rows[i].is_angle;
    gap = is_angle ? 0 : off;
    turn = is_angle ? off : 0;
    worst = static_cast<int>(mechanism.cuts.size() + i);
  }
  const std::string metres = text::rounded(std::max(0.0, gap), 3) + " m";
  return turn > acceptable ? metres + " and " + text::rounded(turn, 3) + " rad" : metres;
}

std::vector<double> close_loops(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                const Wishes& tree, int& tries) {
  std::vector<double> best;
  double smallest = INFINITY;
  for (tries = 1; tries <= most_tries; ++tries) {
    std::vector<double> q = start_of_try(problem, tree, tries - 1);
    const double gap = close(problem, q);
    if (gap <= acceptable) return q;
    if (best.empty() || gap < smallest) {
      best = q;
      smallest = gap;
    }
  }
  problem.gap(best);
  int worst = 0;
  const std::string gap = gap_text(mechanism, dynamics, worst);
  throw CannotAssemble(gap, worst, best);
}

std::vector<double> consistent_speeds(AssemblyProblem& problem, const std::vector<double>& q) {
  AssemblyProblem::Speeds s = problem.speeds(q);
  const auto& free = problem.free(AssemblyProblem::Level::velocity);
  const auto n = static_cast<Eigen::Index>(free.size());
  VectorXd v = VectorXd::Zero(n);
  if (s.G.rows() > 0 && n > 0) v = -s.G.completeOrthogonalDecomposition().solve(s.g0);
  const VectorXd left = s.G.rows() > 0 ? VectorXd(s.G * v + s.g0) : VectorXd();
  double speed = 1;
  for (const double fixed : s.v) speed = std::max(speed, std::abs(fixed));
  if (largest(left) > acceptable * speed * problem.length()) {
    throw CannotAssemble(text::rounded(largest(left), 3), -1, q);
  }
  const MatrixXd Z = nullspace(s.G, n);
  if (Z.cols() > 0) {
    const VectorXd d = s.T * v + s.d0;
    v -= Z * (s.T * Z).completeOrthogonalDecomposition().solve(d);
  }
  for (Eigen::Index k = 0; k < n; ++k) s.v[free[static_cast<std::size_t>(k)]] = v[k];
  return s.v;
}

}  // namespace

Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const Wishes& tree, const Wishes& cuts) {
  Assembled out;
  if (mechanism.rows == 0 && mechanism.cuts.empty()) {
    out.q = tree.q;
    out.v = tree.v;
    return out;
  }
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  out.q = close_loops(mechanism, dynamics, problem, tree, out.tries);
  come_near(problem, out.q);
  const VectorXd moved = problem.distance(out.q);
  for (int k = 0; k < mechanism.nv; ++k) {
    if (tree.q_weight[k] >= 1) out.moved = std::max(out.moved, std::abs(moved[k]) / std::sqrt(tree.q_weight[k]));
  }
  out.v = consistent_speeds(problem, out.q);
  return out;
}

}  // namespace gelenk
