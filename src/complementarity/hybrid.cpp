// SPDX-License-Identifier: BSD-3-Clause
// The default. With a matrix, up to about a hundred contacts: semismooth Newton, led by some steps of the spectral
// projected gradient where it stalls; after Gauss-Seidel sweeps where the tolerance is loose. Larger problems with a
// sparse root of G: Newton's method and the augmented Lagrangian method in the space of velocities in turn, or
// Gauss-Seidel sweeps in loose heaps and where factors fill in. Without a root: the accelerated gradient, with Newton's
// method up to some hundred contacts if there is a matrix.
#include <algorithm>
#include <cmath>
#include <limits>

#include "complementarity/accelerated_gradient.h"
#include "complementarity/augmented_lagrangian.h"
#include "complementarity/gauss_seidel.h"
#include "complementarity/newton.h"
#include "complementarity/spectral_gradient.h"

namespace gelenk {
namespace {

constexpr Eigen::Index newton_first = 300;   // unknowns, up to which Newton's method with a matrix comes first
constexpr Eigen::Index newton_at_all = 900;  // unknowns, up to which it is used: some tenths of a second per step
constexpr Eigen::Index swept_first = 60;     // unknowns, from which sweeps come first where the tolerance is loose
constexpr double loose_tolerance = 3e-8;     // relative to the largest velocity
constexpr int newton_steps = 100;
constexpr int fixed_point_steps = 200;  // between attempts at the exact problem
constexpr int spectral_steps = 30;
constexpr int accelerated_steps = 300;
// With a sparse root:
constexpr double max_factor_cost = 3e8;        // multiplications, some tenths of a second
constexpr double max_loose_rows = 1.5;         // of contacts, per velocity that they change: loose heaps
constexpr double max_products_per_factor = 8;  // that cost as much as a factorization, in loose heaps
constexpr int sweeps_without_gain = 250;       // of a factor of two
constexpr int first_newton_steps = 8;  // from the impulses of the last step, which are close unless bodies strike
// Residuals of the impulses of the last step, relative to the largest velocity: where only rounding has changed, and
// where they are a good guess.
constexpr double resting = 1e-7;
constexpr double near = 1e-3;
constexpr int first_sweeps = 1500;
constexpr int first_patience = 200;  // sweeps without a gain of a factor of two
constexpr double near_enough = 1e-6;
constexpr int last_newton_steps = 5;  // they suffice where the right contacts slide
constexpr int sparse_newton_steps = 30;
constexpr int proximal_steps = 12;
// At rest, relative to the mean diagonal of G: smaller weights make the first step of Newton's method fail.
constexpr double resting_weight = 1e-5;
constexpr double least_gain = 0.5;  // of the residual, by both methods; otherwise they failed
constexpr int max_failures = 3;     // in a row

class HybridSolver final : public IterativeConeSolver {
  void run(ConeIteration& at) override {
    if (at.G().dense() == nullptr && !at.G().root().first.empty()) return run_sparse(at);
    if (at.size() > newton_at_all || (at.size() > newton_first && at.G().dense() == nullptr)) {
      accelerated_.run(at, std::numeric_limits<int>::max());
    } else {
      run_dense(at);
    }
  }

  void run_dense(ConeIteration& at) {
    newton_.reserve(at.size(), at.cones().size());
    const bool sweeps_are_enough =
        at.exact() && at.size() >= swept_first && at.tolerance() > loose_tolerance * fastest(at);
    if (sweeps_are_enough && solve_by_sweeps(at)) return;
    bool newton = at.size() <= newton_first;
    for (; !at.done(); newton = !newton) {
      at.return_to(Iterate::best);
      if (newton) {
        newton_.run(at, newton_steps);
        for (int k = 0; k < fixed_point_steps && at.exact() && !at.done(); ++k) fixed_point_step(at, k == 0);
      } else if (at.size() <= newton_first) {
        spectral_.run(at, spectral_steps);
      } else {
        accelerated_.run(at, accelerated_steps);
      }
    }
  }

  // Ends early if nothing gains any more.
  void run_sparse(ConeIteration& at) {
    hessian_.start(at);
    if (sweeps_suffice(at)) return sweeps_.run(at, std::numeric_limits<int>::max(), sweeps_without_gain);
    newton_.reserve(at.size(), at.cones().size(), &hessian_);
    // At rest, redundant impulses are not determined: Newton's method wanders among them, the proximal one stays near.
    if (is_near(at, resting)) {
      lagrangian_.run(at, hessian_, proximal_steps, resting_weight);
      at.return_to(Iterate::best);
    } else if (at.exact() && solve_by_sweeps(at)) {
      return;
    }
    for (int failures = 0; !at.done() && failures < max_failures;) {
      const double before = at.best_residual();
      newton_.run(at, sparse_newton_steps);
      at.return_to(Iterate::best);
      if (!at.done()) lagrangian_.run(at, hessian_, proximal_steps, AugmentedLagrangian::largest_weight);
      at.return_to(Iterate::best);
      failures = at.best_residual() < least_gain * before ? 0 : failures + 1;
    }
  }

  // The largest relative velocity without impulses.
  static double fastest(ConeIteration& at) {
    double largest = 0;
    for (Eigen::Index i = 0; i < at.size(); ++i) largest = std::max(largest, std::abs(at.b()[i]) / at.scale(i));
    return largest;
  }

  static bool is_near(ConeIteration& at, double fraction) { return at.best_residual() <= fraction * fastest(at); }

  // Bodies that strike and slide by Coulomb's law: sweeps come close, and where Newton's method finds no way on from
  // there, the augmented Lagrangian method rarely does, and costs a hundred times as much. Returns whether that is near
  // enough.
  bool solve_by_sweeps(ConeIteration& at) {
    if (is_near(at, near)) newton_.run(at, first_newton_steps);
    if (at.done()) return true;
    at.return_to(Iterate::start);  // failed steps leave impulses that balance each other
    sweeps_.run(at, first_sweeps, first_patience);
    at.return_to(Iterate::best);
    if (at.done()) return true;
    newton_.run(at, last_newton_steps);
    at.return_to(Iterate::best);
    return at.done() || is_near(at, near_enough);
  }

  // Sweeps are quick in loose heaps, whose impulses are nearly determined. Towers and walls, whose blocks touch at
  // several points each, need factors.
  bool sweeps_suffice(const ConeIteration& at) const {
    const bool loose = static_cast<double>(at.size()) < max_loose_rows * hessian_.moved_rows();
    return hessian_.factor_cost() > max_factor_cost ||
           (loose && hessian_.factor_cost() > max_products_per_factor * hessian_.product_cost());
  }

  void reserve(ConeIteration& at) override {
    accelerated_.reserve(at.size());
    if (at.size() > newton_at_all) return;
    spectral_.reserve(at.size());
    shift_.start(at.size());
    if (at.G().dense() != nullptr || at.G().root().first.empty()) newton_.reserve(at.size(), at.cones().size());
  }

  // Solves the convex problem with De Saxce's shift of the present iterate, to a fraction: a step of the fixed-point
  // iteration of FrozenShift, but with Newton's method.
  void fixed_point_step(ConeIteration& at, bool first) {
    if (first) at.return_to(Iterate::best);
    shift_.start(at.size());
    ConeVector shift = shift_.vector(at.size());
    shift.setZero();
    add_lift(at.cones(), at.u().data(), shift.data());
    newton_.run_with(shift.data(), at, newton_steps);
  }

  ConeMemory shift_;
  GaussSeidel sweeps_;
  SemismoothNewton newton_;
  SpectralGradient spectral_;
  AcceleratedGradient accelerated_;
  VelocityHessian hessian_;
  AugmentedLagrangian lagrangian_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_hybrid_cone_solver() { return std::make_unique<HybridSolver>(); }

}  // namespace gelenk
