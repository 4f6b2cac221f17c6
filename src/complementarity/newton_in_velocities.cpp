// SPDX-License-Identifier: BSD-3-Clause
// The reduced system of the semismooth Newton method with a sparse root W of G, by the matrix inversion lemma: with
// A = diag(1 / lambda - 1) + eps,
//   y = A^-1 (rhs - Q^T (1 + S) W^T w),   (1 + W Q A^-1 Q^T (1 + S) W^T) w = W Q A^-1 rhs,
// where the matrix is that of VelocityHessian with the weights 1 / A and, where contacts slide, an unsymmetric part.
#include <algorithm>

#include "complementarity/newton.h"

namespace gelenk {
namespace {

// GMRES leaves an error of w that 1 / eps amplifies in y.
constexpr double min_eps_sliding = 1e-5;
constexpr double max_eps_refined = 1e-5;
// Iterative refinement, for the equations without eps.
constexpr int max_refinements = 4;
constexpr double refined = 1e-6;  // of the norm of the right side
constexpr double gmres_tolerance = 1e-8;

}  // namespace

// rhs <- y. Returns false if the factorization fails.
bool SemismoothNewton::solve_sparse(ConeIteration& at, double eps) {
  const std::span<const Cone> cones = at.cones();
  if (something_slides(cones)) eps = std::max(eps, min_eps_sliding);
  set_weights(at, eps);
  if (!hessian_->factorize(cones, std::span(modes_).first(cones.size()), std::span(weights_).first(cones.size())))
    return false;
  right_side_.assign(rhs_, rhs_ + rows_);
  left_ = right_side_;
  y_.resize(right_side_.size());
  std::fill_n(rhs_, rows_, 0.0);
  const double size = ConeVector(left_.data(), rows_).norm();
  double best = size;
  for (int k = 0; k < max_refinements && best > refined * size; ++k) {
    solve_in_velocities(at);
    for (std::size_t r = 0; r < y_.size(); ++r) y_[r] += rhs_[r];
    const double now = set_left(at);
    if (k > 0 && !(now < best)) break;
    std::ranges::copy(y_, rhs_);
    best = now;
    if (eps > max_eps_refined) break;
  }
  return true;
}

// Whether s(u) of the cone has a derivative.
bool SemismoothNewton::slides(const Cone& cone) const {
  const double* sigma = sigma_ + cone.first;
  return std::any_of(sigma, sigma + cone.size(), [](double component) { return component != 0; });
}

bool SemismoothNewton::something_slides(std::span<const Cone> cones) const {
  if (!exact_) return false;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    if (!slides(cones[i])) continue;
    for (int k = 0; k < modes_[i].count; ++k) {
      if (modes_[i].q[at_index(k)][0] != 0) return true;
    }
  }
  return false;
}

// The weights 1 / A and, by cone, the vectors Q A^-1 Q^T e_n that sigma^T W^T w multiplies.
void SemismoothNewton::set_weights(ConeIteration& at, double eps) {
  const std::span<const Cone> cones = at.cones();
  if (weights_.size() < cones.size()) weights_.resize(cones.size());
  lifted_.assign(static_cast<std::size_t>(at.size()), 0.0);
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const bool lifts = exact_ && slides(cones[i]);
    for (int k = 0; k < modes_[i].count; ++k) {
      const auto& q = modes_[i].q[at_index(k)];
      const double weight = 1 / (1 / modes_[i].lambda[at_index(k)] - 1 + eps);
      weights_[i][at_index(k)] = weight;
      if (!lifts) continue;
      for (int c = 0; c < cones[i].size(); ++c) lifted_[at_index(cones[i].first + c)] += weight * q[0] * q[at_index(c)];
    }
  }
}

// y <- the solution of the reduced system with eps for the right side `left`.
void SemismoothNewton::solve_in_velocities(ConeIteration& at) {
  const std::span<const Cone> cones = at.cones();
  for (std::size_t i = 0; i < cones.size(); ++i) {
    for (int k = 0; k < modes_[i].count; ++k) {
      const std::size_t r = at_index(first_[i] + k);
      y_[r] = left_[r] * weights_[i][at_index(k)];
    }
  }
  std::fill_n(trial_F_, at.size(), 0.0);
  expand(at, y_.data(), trial_F_);
  hessian_->multiply(trial_F_, right_);
  hessian_->solve_lifted(cones, sigma_, lifted_.data(), gmres_tolerance, right_, w_);
  hessian_->multiply_transposed(w_, trial_F_);
  std::array<double, Cone::max_size> change{};
  for (std::size_t i = 0; i < cones.size(); ++i) {
    project_on_modes(cones[i], modes_[i], trial_F_ + cones[i].first, change.data());
    for (int k = 0; k < modes_[i].count; ++k) {
      const std::size_t r = at_index(first_[i] + k);
      y_[r] = (left_[r] - change[at_index(k)]) * weights_[i][at_index(k)];
    }
  }
}

// left <- what y leaves of the right side in the reduced system without eps. Returns its norm.
double SemismoothNewton::set_left(ConeIteration& at) {
  const std::span<const Cone> cones = at.cones();
  std::fill_n(trial_x_, at.size(), 0.0);
  expand(at, y_.data(), trial_x_);
  at.multiply(trial_x_, trial_u_);
  std::array<double, Cone::max_size> change{};
  for (std::size_t i = 0; i < cones.size(); ++i) {
    project_on_modes(cones[i], modes_[i], trial_u_ + cones[i].first, change.data());
    for (int k = 0; k < modes_[i].count; ++k) {
      const std::size_t r = at_index(first_[i] + k);
      left_[r] = right_side_[r] - change[at_index(k)] - (1 / modes_[i].lambda[at_index(k)] - 1) * y_[r];
    }
  }
  return ConeVector(left_.data(), rows_).norm();
}

}  // namespace gelenk
