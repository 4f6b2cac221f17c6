// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/newton.h"

#include <algorithm>
#include <array>
#include <limits>

#include "linear/dense_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;

// Regularization relative to the mean diagonal of G: above the rounding of the factorization (1e-13 of 300 unknowns),
// and raised to the last value if smaller ones give no progress.
constexpr double regularizations[] = {1e-9, 1e-7, 1e-4, 1e-2};
constexpr double merit_decrease = 0.1;    // of the squared norm of the natural map
constexpr double solved_fraction = 1e-6;  // of a problem with a constant shift, squared
constexpr int newton_patience = 20;       // steps without a new least value after which the method gives up
constexpr int halvings = 10;              // of a step

}  // namespace

void SemismoothNewton::reserve(Index n, std::size_t cones, VelocityHessian* hessian) {
  constexpr Index columns = Cone::max_size;
  hessian_ = hessian;
  memory_.start((9 + (hessian ? 0 : columns + n)) * n);
  for (double** piece : {&z_, &F_, &sigma_, &dx_, &Gdx_, &trial_x_, &trial_u_, &trial_F_, &rhs_}) {
    *piece = memory_.take(n);
  }
  if (!hessian) {
    T_ = memory_.take(columns * n);
    A_ = memory_.take(n * n);
  }
  if (modes_.size() < cones) modes_.resize(cones);
  if (first_.size() < cones) first_.resize(cones);
  if (pivots_.size() < static_cast<std::size_t>(n)) pivots_.resize(static_cast<std::size_t>(n));
}

// F <- the natural map; returns its squared norm. Uses z.
double SemismoothNewton::natural_map(ConeIteration& at, const double* x, const double* u, double* F) const {
  const Index n = at.size();
  std::fill_n(z_, n, 0.0);
  if (exact_) add_lift(at.cones(), u, z_);
  if (shift_) std::copy_n(shift_, n, z_);
  for (Index i = 0; i < n; ++i) z_[i] = x[i] - u[i] - z_[i];
  at.project_all(z_, F);
  double sum = 0;
  for (Index i = 0; i < n; ++i) {
    F[i] = x[i] - F[i];
    sum += F[i] * F[i];
  }
  return sum;
}

// The modes of the projection at z, and sigma: the derivative of the normal component of s(u).
void SemismoothNewton::linearize(ConeIteration& at) {
  int rows = 0;
  std::size_t k = 0;
  std::fill_n(sigma_, at.size(), 0.0);
  for (const Cone& cone : at.cones()) {
    projection_modes(cone, z_ + cone.first, modes_[k]);
    first_[k] = rows;
    rows += modes_[k].count;
    ++k;
    if (!exact_ || cone.interval) continue;
    for (const ConeGroup& group : cone.limited()) {
      const auto u = at.u().segment(cone.first + group.offset, group.size);
      const double length = u.norm();
      if (length == 0) continue;
      for (int i = 0; i < group.size; ++i) sigma_[cone.first + group.offset + i] = group.coefficient * u[i] / length;
    }
  }
  rows_ = rows;
}

// T <- column k of D G D Q_j for each mode k of a cone, from this row on.
void SemismoothNewton::move_by_modes(ConeIteration& at, const Cone& cone, const ProjectionModes& modes, Index from) {
  const Index n = at.size();
  const Eigen::Map<const Eigen::MatrixXd> G = at.matrix();
  for (int k = 0; k < modes.count; ++k) {
    ConeVector T(T_ + k * n, n);
    T.tail(n - from).setZero();
    for (int c = 0; c < cone.size(); ++c) {
      const double q = modes.q[at_index(k)][at_index(c)] * at.scale(cone.first + c);
      if (q != 0) T.tail(n - from) += q * G.col(cone.first + c).tail(n - from);
    }
    for (Index i = from; i < n; ++i) T[i] *= at.scale(i);
  }
}

// Q_i^T (1 + S) T for the modes of one cone and one column T, of which `velocity` has the cone's components.
void SemismoothNewton::project_on_modes(const Cone& cone, const ProjectionModes& modes, const double* velocity,
                                        double* out) const {
  const int size = cone.size();
  double normal = velocity[0];
  for (int c = 1; c < size; ++c) normal += sigma_[cone.first + c] * velocity[c];
  for (int r = 0; r < modes.count; ++r) {
    const auto& q = modes.q[at_index(r)];
    double sum = q[0] * normal;
    for (int c = 1; c < size; ++c) sum += q[at_index(c)] * velocity[c];
    out[r] = sum;
  }
}

// The matrix of the reduced system, for a convex problem only its lower triangle.
void SemismoothNewton::assemble(ConeIteration& at, double eps) {
  const Index n = at.size();
  ConeMatrix A(A_, rows_, rows_);
  const std::span<const Cone> cones = at.cones();
  for (std::size_t j = 0; j < cones.size(); ++j) {
    move_by_modes(at, cones[j], modes_[j], exact_ ? 0 : cones[j].first);
    for (int k = 0; k < modes_[j].count; ++k) {
      const Index column = first_[j] + k;
      for (std::size_t i = exact_ ? 0 : j; i < cones.size(); ++i) {
        project_on_modes(cones[i], modes_[i], T_ + k * n + cones[i].first, A_ + column * rows_ + first_[i]);
      }
      A(column, column) += 1 / modes_[j].lambda[at_index(k)] - 1 + eps;
    }
  }
}

// dx <- dx_0, and the right side of the reduced system.
void SemismoothNewton::right_side(ConeIteration& at) {
  const std::span<const Cone> cones = at.cones();
  bool moved = false;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const double* F = F_ + cones[i].first;
    double* dx = dx_ + cones[i].first;
    for (int c = 0; c < cones[i].size(); ++c) dx[c] = -F[c];
    for (int k = 0; k < modes_[i].count; ++k) {
      const auto& q = modes_[i].q[at_index(k)];
      double along = 0;
      for (int c = 0; c < cones[i].size(); ++c) along += q[at_index(c)] * F[c];
      rhs_[first_[i] + k] = -along / modes_[i].lambda[at_index(k)];
      for (int c = 0; c < cones[i].size(); ++c) dx[c] += q[at_index(c)] * along;
    }
    for (int c = 0; c < cones[i].size(); ++c) moved = moved || dx[c] != 0;
  }
  if (!moved || rows_ == 0) return;
  at.multiply(dx_, Gdx_);
  std::array<double, Cone::max_size> change{};
  for (std::size_t i = 0; i < cones.size(); ++i) {
    project_on_modes(cones[i], modes_[i], Gdx_ + cones[i].first, change.data());
    for (int k = 0; k < modes_[i].count; ++k) rhs_[first_[i] + k] -= change[at_index(k)];
  }
}

// rhs <- the solution y of the reduced system.
void SemismoothNewton::solve_reduced(bool general, double eps) {
  const ConeMatrix A(A_, rows_, rows_);
  ConeVector y(rhs_, rows_), correction(T_, rows_);
  const auto solve = [&](const ConeVector& x) {
    if (general) {
      solve_general(A, pivots_.data(), x);
    } else {
      solve_symmetric(A, x);
    }
  };
  if (general) {
    factorize_general(A, pivots_.data(), eps);
  } else {
    factorize_symmetric(A, eps);
  }
  solve(y);
  if (eps > regularizations[0]) return;
  // (A + eps) y = rhs leaves eps y in A y = rhs: a step of iterative refinement removes it up to eps^2.
  correction = eps * y;
  solve(correction);
  y += correction;
}

// x <- x + Q y
void SemismoothNewton::expand(ConeIteration& at, const double* y, double* x) const {
  const std::span<const Cone> cones = at.cones();
  for (std::size_t i = 0; i < cones.size(); ++i) {
    for (int k = 0; k < modes_[i].count; ++k) {
      const double along = y[first_[i] + k];
      for (int c = 0; c < cones[i].size(); ++c) x[cones[i].first + c] += along * modes_[i].q[at_index(k)][at_index(c)];
    }
  }
}

// dx <- the Newton step for this regularization, and Gdx. False if it is not finite.
bool SemismoothNewton::find_step(ConeIteration& at, double eps) {
  right_side(at);
  if (rows_ > 0) {
    if (hessian_) {
      if (!solve_sparse(at, eps)) return false;
    } else {
      assemble(at, eps);
      solve_reduced(exact_, eps);
    }
    expand(at, rhs_, dx_);
  }
  if (!ConeVector(dx_, at.size()).allFinite()) return false;
  at.multiply(dx_, Gdx_);
  return true;
}

// Moves along dx, halving the step until the natural map is smaller than the largest of the last ones. False if it
// never is.
bool SemismoothNewton::take_step(ConeIteration& at) {
  const Index n = at.size();
  const double largest = *std::max_element(merits_.begin(), merits_.end());
  double fraction = 1;
  for (int k = 0; k <= halvings; ++k, fraction /= 2) {
    for (Index i = 0; i < n; ++i) {
      trial_x_[i] = at.x()[i] + fraction * dx_[i];
      trial_u_[i] = at.u()[i] + fraction * Gdx_[i];
    }
    const double merit = natural_map(at, trial_x_, trial_u_, trial_F_);
    if (merit < (1 - merit_decrease * fraction) * largest) {
      std::copy_n(trial_x_, n, at.x().data());
      std::copy_n(trial_u_, n, at.u().data());
      return true;
    }
  }
  return false;
}

void SemismoothNewton::run(ConeIteration& at, int max_steps) {
  exact_ = at.exact();
  shift_ = nullptr;
  iterate(at, max_steps, 0);
}

void SemismoothNewton::run_with(const double* shift, ConeIteration& at, int max_steps) {
  exact_ = false;
  shift_ = shift;
  iterate(at, max_steps, solved_fraction);
}

// Ends, too, if the natural map's squared norm is below this fraction of that at the start.
void SemismoothNewton::iterate(ConeIteration& at, int max_steps, double fraction) {
  reserve(at.size(), at.cones().size(), hessian_);
  merits_.fill(0);
  double first = 0;
  double least = std::numeric_limits<double>::infinity();
  int least_at = 0;
  for (int step = 0; step < max_steps && step - least_at < newton_patience; ++step) {
    const double merit = natural_map(at, at.x().data(), at.u().data(), F_);
    if (step == 0) first = merit;
    if (step > 0 && merit < fraction * first) return;
    merits_[static_cast<std::size_t>(step) % merits_.size()] = merit;
    if (merit < least) {
      least = merit;
      least_at = step;
    }
    linearize(at);
    bool moved = false;
    for (const double eps : regularizations) {
      if (!find_step(at, eps)) continue;
      moved = take_step(at);
      if (moved) break;
    }
    if (!at.advance() || !moved) return;
  }
}

namespace {

class NewtonSolver final : public IterativeConeSolver {
  void reserve(ConeIteration& at) override { method_.reserve(at.size(), at.cones().size()); }
  void run(ConeIteration& at) override {
    constexpr int all = 1 << 30;
    method_.run(at, all);
  }
  SemismoothNewton method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_newton_cone_solver() { return std::make_unique<NewtonSolver>(); }

}  // namespace gelenk
