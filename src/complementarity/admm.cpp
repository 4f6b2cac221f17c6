// SPDX-License-Identifier: BSD-3-Clause
// The alternating direction method of multipliers (Boyd et al. 2011, sec. 3.4; over-relaxed), with a penalty that
// balances the relative primal and dual residuals (Stellato et al. 2020). An iteration solves with the factors of
// G + rho and multiplies with G for the residual: it counts as two products.
#include <algorithm>
#include <cmath>

#include "complementarity/iteration.h"
#include "complementarity/shift.h"
#include "linear/dense_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr double relaxation = 1.8;
constexpr int balance_interval = 10;  // iterations between changes of the penalty
constexpr double imbalance = 5;       // a smaller factor is not worth a factorization
constexpr double min_penalty = 1e-8, max_penalty = 1e4;

class Admm {
 public:
  void reserve(Index n) { memory_.start(5 * n + n * n); }
  void run(ConeIteration& at) {
    const Index n = at.size();
    reserve(n);
    ConeVector shift = memory_.vector(n), free = memory_.vector(n), w = memory_.vector(n), last = memory_.vector(n);
    ConeVector work = memory_.vector(n);
    ConeMatrix A = memory_.matrix(n, n);
    FrozenShift frozen(at, shift.data(), work.data());
    double penalty = 0.1;
    factorize(at, penalty, A);
    w = -(at.u() + shift) / penalty;  // multipliers of the initial guess
    for (int k = 1;; ++k) {
      last = at.x();
      free = penalty * (last - w) - at.b() - shift;
      solve_symmetric(A, free);
      at.count_product();
      work = relaxation * free + (1 - relaxation) * last + w;
      at.project_all(work.data(), at.x().data());
      w = work - at.x();
      at.update_velocity();
      if (!at.advance()) return;
      frozen.renew_if_solved();
      if (k % balance_interval != 0) continue;
      const double primal = (free - at.x()).norm() / std::max(free.norm(), at.x().norm());
      const double dual =
          penalty * (at.x() - last).norm() / std::max((at.u() - at.b()).norm(), (at.b() + shift).norm());
      const double factor = std::sqrt(primal / dual);
      if (!std::isfinite(factor) || (factor < imbalance && factor > 1 / imbalance)) continue;
      const double next = std::clamp(factor * penalty, min_penalty, max_penalty);
      w *= penalty / next;
      penalty = next;
      factorize(at, penalty, A);
    }
  }

 private:
  // A <- the factors of D G D + penalty
  static void factorize(ConeIteration& at, double penalty, ConeMatrix& A) {
    const auto G = at.matrix();
    for (Index j = 0; j < at.size(); ++j) {
      for (Index i = j; i < at.size(); ++i) A(i, j) = at.scale(i) * G(i, j) * at.scale(j);
      A(j, j) += penalty;
    }
    factorize_symmetric(A, penalty);
  }

  ConeMemory memory_;
};

class AdmmSolver final : public IterativeConeSolver {
  void reserve(ConeIteration& at) override { method_.reserve(at.size()); }
  void run(ConeIteration& at) override { method_.run(at); }
  Admm method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_admm_cone_solver() { return std::make_unique<AdmmSolver>(); }

}  // namespace gelenk
