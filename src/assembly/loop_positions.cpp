// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/loop_positions.h"

#include <algorithm>
#include <cmath>

#include "decomposition/singular_values.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double longest_closing_step =
    0.3;                               // rad or m, of a closing step: the linearized equations are inaccurate beyond
constexpr double stride = 0.4;         // rad or m, between positions, so that they differ clearly
constexpr double min_progress = 0.05;  // rad or m: a step that moves less has reached the end of the range of motion
// Relative to the largest singular value: at regular positions of mechanisms of all proportions it is 1e-3 or more.
constexpr double min_singular_ratio = 1e-4;
constexpr double near_singular_ratio = 1e-3;  // smaller ratios occur near singular positions
// Ratio of the last singular value that counts to the first one that does not.
constexpr double min_rank_gap = 10;

}  // namespace

LoopPositions::Position LoopPositions::closed(std::vector<double> q) const {
  const auto linearized = [&](const auto& at) {
    return [J = SingularValues(loops_.equations(at).J), this](const VectorXd& Phi, double damping) -> VectorXd {
      if (J.sigma.size() == 0 || J.sigma[0] == 0) return {};
      return -J.solve(Phi, rank_, damping * J.sigma[0] * J.sigma[0]);
    };
  };
  // The equations contradict each other, so the least closure error is not zero; it is reached when it no longer
  // decreases.
  const VectorXd left = descend(
      q, {.min_progress = 1e-3, .max_step = longest_closing_step, .max_steps = 80},
      [&](const auto& at) { return loops_.equations(at).Phi; }, linearized,
      [&](const auto& at, const VectorXd& step) { return loops_.displaced(at, step); });
  return {q, largest(left), SingularValues(loops_.equations(q).J).sigma};
}

bool LoopPositions::is_regular(const Position& position) const {
  const VectorXd& sigma = position.sigma;
  if (rank_ == 0 || sigma.size() == 0) return true;
  const double beyond = rank_ < sigma.size() ? sigma[rank_] : 0;
  return sigma[rank_ - 1] > std::max(min_singular_ratio * sigma[0], min_rank_gap * beyond);
}

VectorXd LoopPositions::free_direction(const std::vector<double>& q, std::mt19937& random) const {
  const SingularValues J(loops_.equations(q).J);
  std::normal_distribution<double> normal;
  // At a singular position branches meet, and more motions are free than on any one of them.
  Index held = 0;
  while (held < rank_ && J.sigma[held] > near_singular_ratio * J.sigma[0]) ++held;
  VectorXd along(J.V.cols() - held);
  for (double& x : along) x = normal(random);
  const VectorXd out = J.V.rightCols(along.size()) * along;
  return out / largest(out);
}

std::vector<std::vector<double>> LoopPositions::walk(const Position& start, std::size_t count, unsigned seed) const {
  std::vector<std::vector<double>> out;
  if (is_regular(start) && start.gap <= misfit_) out.push_back(start.q);
  if (rank_ == loops_.velocities()) return out;
  std::mt19937 random(seed);
  std::vector<double> at = start.q;
  VectorXd last;  // direction of the last step, or its opposite after an end of the range
  for (std::size_t i = 0; i < 6 * count && out.size() < count; ++i) {
    VectorXd ahead = free_direction(at, random);
    if (last.size() > 0 && ahead.dot(last) < 0) ahead = -ahead;
    Position next = closed(loops_.displaced(at, stride * ahead));
    double moved = 0;
    for (std::size_t k = 0; k < at.size(); ++k) moved = std::max(moved, std::abs(next.q[k] - at[k]));
    if (!(next.gap <= misfit_) || moved < min_progress) {
      at = start.q;
      if (is_regular(start)) {
        last = -ahead;
      } else {
        last.resize(0);
      }
      continue;
    }
    last = ahead;
    at = std::move(next.q);
    next.q = at;
    if (is_regular(next)) out.push_back(at);
  }
  return out;
}

}  // namespace gelenk
