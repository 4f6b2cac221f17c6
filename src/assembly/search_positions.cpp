// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/search_positions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Level = AssemblyProblem::Level;

// A rotation by up to `reach` about any axis; all orientations are equally likely if it is half a turn.
Eigen::Quaterniond random_rotation(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> within(-1, 1);
  std::normal_distribution<double> normal;
  if (reach >= std::numbers::pi) {
    Eigen::Vector4d Q;
    do {
      for (double& x : Q) x = normal(random);
    } while (Q.norm() < 0.1);
    Q.normalize();
    return {Q[3], Q[0], Q[1], Q[2]};
  }
  Eigen::Vector3d turn;
  do {
    for (double& x : turn) x = within(random);
  } while (turn.norm() > 1 || turn.norm() < 1e-3);
  return Eigen::Quaterniond(Eigen::AngleAxisd(reach * turn.norm(), turn.normalized()));
}

}  // namespace

std::vector<double> perturbed(const AssemblyProblem& problem, const std::vector<double>& q, int attempt) {
  if (attempt == 0) return q;
  std::mt19937 random(static_cast<unsigned>(attempt));
  // Small at first, for guesses at a dead center; finally over the whole range.
  const double reach = std::min(std::numbers::pi, 0.05 * std::pow(1.35, attempt));
  std::uniform_real_distribution<double> perturbation(-reach, reach);
  const auto n = static_cast<Eigen::Index>(problem.free(Level::position).size());
  Eigen::VectorXd step(n);
  for (Eigen::Index k = 0; k < n; ++k) step[k] = perturbation(random) * problem.length();
  return problem.displaced(q, step);
}

std::vector<double> random_position(const AssemblyProblem& problem, std::mt19937& random,
                                    const AssemblyProblem::Squared& within) {
  const InitialGuess& guesses = problem.guesses();
  std::uniform_real_distribution<double> change(-1, 1);
  const auto reach = [&](int v, double whole) {
    const double weight = guesses.q_weight[v];
    if (weight <= 0) return whole;
    return std::min(whole, std::sqrt((guesses.q_given[v] ? within.given : within.other) / weight));
  };
  std::vector<double> q = guesses.q;
  for (const Link& link : problem.mechanism().links) {
    const int plain = link.nq > link.nv ? link.nq - 4 : link.nq;
    for (int i = 0; i < plain; ++i) {
      const int v = link.iv + i;
      if (!guesses.q_fixed[v])
        q[link.iq + i] += change(random) * reach(v, guesses.turns[v] ? std::numbers::pi : problem.span());
    }
    if (plain == link.nq || guesses.q_fixed[link.iv + plain]) continue;
    Eigen::Map<Eigen::Vector4d> Q(q.data() + link.iq + plain);
    const Eigen::Quaterniond guess(Q[3], Q[0], Q[1], Q[2]);
    Q = (guess * random_rotation(random, reach(link.iv + plain, std::numbers::pi))).coeffs();
  }
  return q;
}

}  // namespace gelenk
