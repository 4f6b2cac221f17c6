// SPDX-License-Identifier: BSD-3-Clause
#include "linear/box_complementarity.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "linear/row_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int first_sweeps = 20;
// Pivots below this fraction of the largest are rounding. A wrong choice shows in the residual.
constexpr double least_pivot = 1e-13;
// Rounding of a product W x, relative to its largest term.
constexpr double rounding = 1e-15;

// A solution of W x = b in which redundant entries are 0, by Cholesky's method with pivoting (Higham 2002, sec. 10.3),
// in a fraction of the time of least_squares().
VectorXd basic_solution(MatrixXd W, VectorXd b) {
  const Index n = b.size();
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  const double largest = W.diagonal().maxCoeff();
  Index rank = 0;
  for (; rank < n; ++rank) {
    Index best = 0;
    const double pivot = W.diagonal().tail(n - rank).maxCoeff(&best);
    if (!(pivot > least_pivot * largest)) break;
    best += rank;
    W.row(rank).swap(W.row(best));
    W.col(rank).swap(W.col(best));
    std::swap(b[rank], b[best]);
    std::swap(order[static_cast<std::size_t>(rank)], order[static_cast<std::size_t>(best)]);
    const Index rest = n - rank - 1;
    W.col(rank).tail(rest + 1) /= std::sqrt(pivot);
    for (Index j = rank + 1; j < n; ++j) W.col(j).tail(rest) -= W(j, rank) * W.col(rank).tail(rest);
  }
  const auto L = W.topLeftCorner(rank, rank).triangularView<Eigen::Lower>();
  VectorXd y = b.head(rank);
  L.solveInPlace(y);
  L.transpose().solveInPlace(y);
  VectorXd x = VectorXd::Zero(n);
  for (Index k = 0; k < rank; ++k) x[order[static_cast<std::size_t>(k)]] = y[k];
  return x;
}

// Of a single unknown, as most impacts and most limits of a mechanism have.
BoxSolution solve_single(double w, double b, double lower, double upper) {
  const double sought = w > 0 ? b / w : b > 0 ? INFINITY : b < 0 ? -INFINITY : 0;
  const double x = std::clamp(sought, lower, upper);
  const bool is_inside = sought > lower && sought < upper;
  const bool found = std::isfinite(x);
  const double r = is_inside ? 0 : found ? b - w * x : b;
  const int at_bound = is_inside || !found ? 0 : lower == upper ? (r < 0 ? -1 : 1) : x == upper ? 1 : -1;
  return {VectorXd::Constant(1, found ? x : 0), VectorXd::Constant(1, r), {at_bound}, found};
}

class ActiveSet {
 public:
  ActiveSet(const MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper, double tolerance)
      : W_(W), b_(b), lower_(lower), upper_(upper), x_(VectorXd::Zero(b.size())), held_(b.size(), 0) {
    const double largest = W_.cwiseAbs().maxCoeff();
    tolerance_ = tolerance * b_.cwiseAbs().maxCoeff();
    for (Index i = 0; i < b.size(); ++i) {
      held_[i] = lower_[i] == upper_[i] ? 1 : 0;  // both are 0
      const double bound = std::max(std::abs(lower_[i]), std::abs(upper_[i]));
      if (std::isfinite(bound)) tolerance_ = std::max(tolerance_, rounding * bound * largest);
    }
  }

  BoxSolution solve() {
    // Each pass ends at the minimum over a face of the box, lower than those before. There are 3^n; in practice it
    // takes about n.
    const Index max_passes = 50 + 20 * b_.size();
    bool found = false;
    approach();
    for (Index pass = 0; pass < max_passes && !found; ++pass) {
      if (!descend()) break;
      found = !release();
    }
    if (found) shorten();
    const VectorXd r = residual();
    // Where both bounds are 0, the residual decides which of them acts.
    for (Index i = 0; i < r.size(); ++i) {
      if (lower_[i] == upper_[i] && r[i] < 0) held_[i] = -1;
    }
    return {x_, r, held_, found};
  }

 private:
  VectorXd residual() const { return b_ - W_ * x_; }
  std::vector<Index> free() const {
    std::vector<Index> out;
    for (Index i = 0; i < x_.size(); ++i) {
      if (held_[i] == 0) out.push_back(i);
    }
    return out;
  }

  // Begins near the solution, by Gauss and Seidel's method, so that most entries that end at a bound are there from the
  // first pass.
  void approach() {
    for (int sweep = 0; sweep < first_sweeps; ++sweep) {
      for (Index i = 0; i < x_.size(); ++i) {
        const double w = W_(i, i);
        if (w > 0) x_[i] = std::clamp(x_[i] + (b_[i] - W_.col(i).dot(x_)) / w, lower_[i], upper_[i]);
      }
    }
    for (Index i = 0; i < x_.size(); ++i) {
      if (held_[i] == 0 && (x_[i] == lower_[i] || x_[i] == upper_[i])) held_[i] = x_[i] == upper_[i] ? 1 : -1;
    }
  }

  // Moves to the minimum over the free entries, holding those that reach a bound on the way. False if there is none.
  bool descend() {
    for (;;) {
      const std::vector<Index> F = free();
      if (F.empty()) return true;
      const VectorXd r = residual()(F);
      const MatrixXd W = W_(F, F);
      VectorXd step = basic_solution(W, r);
      VectorXd left = r - W * step;
      bool bounded = is_rounding(left, W, step);
      if (!bounded) {
        step = least_squares(W, r);
        left = r - W * step;
        bounded = is_rounding(left, W, step);
        // A residual that no step removes is a direction along which the objective falls without bound.
        if (!bounded) step = left;
      }
      const Reach reach = reach_of(F, step, bounded ? 1 : INFINITY);
      if (!std::isfinite(reach.length)) return false;
      for (Index k = 0; k < step.size(); ++k) x_[F[k]] += reach.length * step[k];
      if (reach.stopped < 0) return true;
      hold(F[reach.stopped], step[reach.stopped] > 0 ? 1 : -1);
    }
  }

  // Where rows are nearly dependent, steps are large. What they leave is what later residuals may have, too.
  bool is_rounding(const VectorXd& left, const MatrixXd& W, const VectorXd& step) {
    const double found = left.cwiseAbs().maxCoeff();
    const double terms = W.cwiseAbs().maxCoeff() * step.cwiseAbs().maxCoeff();
    if (!(found <= std::max(tolerance_, rounding * terms))) return false;
    tolerance_ = std::max(tolerance_, found);
    return true;
  }

  // How much of a step stays within the bounds, and the entry that reaches its bound first, or -1.
  struct Reach {
    double length;
    Index stopped;
  };
  Reach reach_of(const std::vector<Index>& F, const VectorXd& step, double length) const {
    Reach out{length, -1};
    for (Index k = 0; k < step.size(); ++k) {
      const double bound = step[k] > 0 ? upper_[F[k]] : lower_[F[k]];
      if (step[k] == 0 || !std::isfinite(bound)) continue;
      const double fraction = std::max(0.0, (bound - x_[F[k]]) / step[k]);
      if (fraction < out.length) out = {fraction, k};
    }
    return out;
  }

  void hold(Index i, int side) {
    held_[i] = side;
    x_[i] = side > 0 ? upper_[i] : lower_[i];
  }

  // Frees the entry whose residual points away from its bound the most. False if there is none.
  bool release() {
    const VectorXd r = residual();
    Index worst = -1;
    double most = tolerance_;
    for (Index i = 0; i < x_.size(); ++i) {
      if (held_[i] == 0 || lower_[i] == upper_[i]) continue;
      const double pull = -held_[i] * r[i];
      if (pull > most) {
        most = pull;
        worst = i;
      }
    }
    if (worst < 0) return false;
    held_[worst] = 0;
    return true;
  }

  // Moves to the solution of least norm on the same face, if it lies in the box.
  void shorten() {
    const std::vector<Index> F = free();
    if (F.empty()) return;
    VectorXd fixed = x_;
    for (const Index i : F) fixed[i] = 0;
    const VectorXd x = least_squares(W_(F, F), (b_ - W_ * fixed)(F));
    for (Index k = 0; k < x.size(); ++k) {
      if (x[k] < lower_[F[k]] || x[k] > upper_[F[k]]) return;
    }
    for (Index k = 0; k < x.size(); ++k) x_[F[k]] = x[k];
  }

  MatrixXd W_;
  VectorXd b_, lower_, upper_;
  VectorXd x_;
  std::vector<int> held_;  // 1: at the upper bound, -1: at the lower one, 0: free
  double tolerance_ = 0;   // of r
};

}  // namespace

VectorXd least_squares(const MatrixXd& W, const VectorXd& b) {
  const int n = static_cast<int>(b.size());
  RowFactor factor(n, n);
  for (int i = 0; i < n; ++i) VectorXd::Map(factor.column(i), n) = W.col(i);
  factor.factorize(n);
  VectorXd x(n);
  factor.min_norm(b.data(), x.data());
  return x;
}

BoxSolution solve_in_box(const MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper,
                         double tolerance) {
  if (b.size() == 0) return {.x = {}, .r = {}, .at_bound = {}, .found = true};
  if (b.size() == 1) return solve_single(W(0, 0), b[0], lower[0], upper[0]);
  // Each unknown in a unit in which its diagonal entry is 1.
  const VectorXd unit = W.diagonal().unaryExpr([](double w) { return w > 0 ? 1 / std::sqrt(w) : 1; });
  BoxSolution out = ActiveSet(unit.asDiagonal() * W * unit.asDiagonal(), unit.cwiseProduct(b),
                              lower.cwiseQuotient(unit), upper.cwiseQuotient(unit), tolerance)
                        .solve();
  for (Index i = 0; i < b.size(); ++i) {
    const int at = out.at_bound[i];
    out.x[i] = at > 0 ? upper[i] : at < 0 ? lower[i] : std::clamp(unit[i] * out.x[i], lower[i], upper[i]);
  }
  out.r = out.r.cwiseQuotient(unit);
  return out;
}

}  // namespace gelenk
