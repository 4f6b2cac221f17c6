// SPDX-License-Identifier: BSD-3-Clause
#include "linear/least_load.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "linear/box_complementarity.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int max_iterations = 50;
// Of the part of b that the forces do not balance: rounding, of b and, where large forces balance each other, of their
// effects.
constexpr double balance_tolerance = 1e-13;
constexpr double effect_rounding = 32 * std::numeric_limits<double>::epsilon();
// Forces along coordinates that move at least at this fraction of the fastest are used up.
constexpr double used_speed = 1e-9;

// A motion of this part of the fastest one is what is left of it when the fraction is found to rounding, so that the
// next fraction differs by little. If it does not, the direction of the motion is rounding, too, and does not say which
// forces are used up; and the forces balance it with a fraction that is larger by this part.
constexpr double balanced_motion = 1e-10;
constexpr double little_change = 1e-6;
constexpr double loosened_part = 1e-9;

// Of rows that are multiples of each other, relative to them.
constexpr double parallel_tolerance = 1e-12;

VectorXd scaled(const VectorXd& bounds, double fraction) {
  return bounds.unaryExpr([&](double x) { return std::isfinite(x) ? fraction * x : x; });
}

// Forces that use all bounds as little as possible, and a motion against which some of them are all used up to the
// same fraction; empty: no bound need be used.
struct Level {
  VectorXd x, motion;
};

// The least fraction of the bounds with which forces stop this motion; slow: speeds that do not count.
double fraction_against(VectorXd motion, const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower,
                        const VectorXd& upper, double slow) {
  // The motion W a needs the power b.a, and the forces give at most the sum of bound_i (W a)_i: a lower bound.
  double resistance = 0;
  for (Index k = 0; k < motion.size(); ++k) {
    // Rounding must not resist where nothing else does, nor need a power where forces are large.
    if (std::abs(motion[k]) <= slow) motion[k] = 0;
    const double bound = motion[k] > 0 ? upper[k] : lower[k];
    if (motion[k] != 0 && std::isfinite(bound)) resistance += bound * motion[k];
  }
  return least_squares(W, motion).dot(b) / resistance;
}

// size: the magnitude of forces, for their rounding.
Level least_level(const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper,
                  double size) {
  Level out{least_squares(W, b), {}};
  double fraction = 0;
  double fastest_of_all = 0;
  for (int i = 0; i < max_iterations; ++i) {
    const auto within = [&](double part) { return solve_in_box(W, b, scaled(lower, part), scaled(upper, part)); };
    const BoxSolution found = within(fraction);
    if (!found.found) break;
    out.x = found.x;
    const double effects = (W.cwiseAbs() * found.x.cwiseAbs()).maxCoeff();
    const double rounding = std::max(balance_tolerance * size, effect_rounding * effects);
    const double fastest = found.r.cwiseAbs().maxCoeff();
    if (fastest <= rounding) break;
    fastest_of_all = std::max(fastest_of_all, fastest);
    const double slow = std::max(used_speed * fastest, rounding);
    const double next = fraction_against(found.r, W, b, lower, upper, slow);
    if (fastest <= balanced_motion * fastest_of_all && !(next <= fraction * (1 + little_change))) {
      if (const BoxSolution loose = within(fraction * (1 + loosened_part)); loose.found) out.x = loose.x;
      break;
    }
    out.motion = found.r;
    if (!std::isfinite(next)) return {least_squares(W, b), {}};  // a force would have to pull that cannot
    if (!(next > fraction)) break;
    fraction = next;
  }
  return out;
}

// The result where all forces act on one motion, W = w w^T, as where several hold a mechanism of one degree of freedom:
// each uses the same fraction of its bound. Returns false, without a result, elsewhere; and where a bound is infinite,
// a force has hardly an effect on the motion, or none resists it.
bool share_one_motion(const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper,
                      VectorXd& x) {
  Index fastest = 0;
  const double largest = W.diagonal().maxCoeff(&fastest);
  if (!(largest > 0)) return false;
  for (Index i = 0; i < b.size(); ++i) {
    if (std::abs(W(i, fastest)) <= used_speed * largest) return false;
    for (Index j = 0; j <= i; ++j) {
      const double off = W(i, j) * largest - W(i, fastest) * W(j, fastest);
      if (std::abs(off) > parallel_tolerance * largest * std::sqrt(W(i, i) * W(j, j))) return false;
    }
  }
  double resistance = 0;  // that they have in all, along the motion of the fastest
  for (Index i = 0; i < b.size(); ++i) {
    x[i] = (W(i, fastest) > 0) == (b[fastest] > 0) ? upper[i] : lower[i];
    if (!std::isfinite(x[i])) return false;
    resistance += std::abs(W(i, fastest) * x[i]);
  }
  if (!(resistance > 0)) return false;
  x *= std::abs(b[fastest]) / resistance;
  return true;
}

// Whether the forces balance b within their bounds, but for rounding that levels may have magnified.
bool are_within(const VectorXd& x, const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower,
                const VectorXd& upper) {
  constexpr double magnified_rounding = 1e-9;
  const double most = magnified_rounding * x.cwiseAbs().maxCoeff();
  const double effects = (W.cwiseAbs() * x.cwiseAbs()).maxCoeff();
  return (x - lower).minCoeff() >= -most && (upper - x).minCoeff() >= -most &&
         (W * x - b).cwiseAbs().maxCoeff() <= magnified_rounding * effects;
}

void find_by_levels(const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper,
                    VectorXd& out) {
  out.setZero();
  const double size = b.cwiseAbs().maxCoeff();
  VectorXd left = b;  // what the forces that are not determined yet have to balance
  std::vector<Index> open(static_cast<std::size_t>(b.size()));
  std::iota(open.begin(), open.end(), Index{0});
  while (!open.empty() && left(open).cwiseAbs().maxCoeff() > balance_tolerance * size) {
    const Level level = least_level(W(open, open), left(open), lower(open), upper(open), size);
    std::vector<Index> next;
    out(open) = level.x;
    if (level.motion.size() == 0) break;
    const double fastest = level.motion.cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Index k = open[i];
      const double speed = level.motion[static_cast<Index>(i)];
      const bool used = std::abs(speed) > used_speed * fastest && std::isfinite(speed > 0 ? upper[k] : lower[k]);
      if (used) {
        left -= out[k] * W.col(k);
      } else {
        next.push_back(k);
      }
    }
    if (next.size() == open.size()) break;
    open = std::move(next);
  }
}

}  // namespace

void least_load(const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper,
                VectorXd& out) {
  out.resize(b.size());
  if (b.size() == 0 || share_one_motion(W, b, lower, upper, out)) return;
  find_by_levels(W, b, lower, upper, out);
  if (are_within(out, W, b, lower, upper)) return;
  // Where forces that suffice exist, rounding has hidden them: their effects are nearly the same.
  const BoxSolution sufficient = solve_in_box(W, b, lower, upper);
  if (sufficient.found && are_within(sufficient.x, W, b, lower, upper)) out = sufficient.x;
}

}  // namespace gelenk
