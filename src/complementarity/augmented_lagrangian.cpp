// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/augmented_lagrangian.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "complementarity/projection.h"

namespace gelenk {
namespace {

using Eigen::Index;

// Weights of the proximal term, relative to the mean diagonal of G.
constexpr double last_weight = 1e-9;
constexpr double weight_decay = 0.1;
// The weight decays where the proximal term causes more than this fraction of the error that the shift causes: a
// smaller weight makes the problems harder, and only more of them help the shift.
constexpr double max_shift_share = 0.5;
constexpr double max_growth = 2;            // of the error, beyond which the acceleration starts again
constexpr double inner_fraction = 0.1;      // of the error, to which a proximal problem is solved
constexpr double curvature_fraction = 0.3;  // of the derivative of psi along a step, that the line search leaves
constexpr int max_trials = 20;              // of the line search
constexpr double weight_growth = 100;       // if a proximal problem is not solved
constexpr int patience = 15;                // steps of Newton's method without a new least error of it

}  // namespace

void AugmentedLagrangian::reserve(Index n) {
  memory_.start(8 * n);
  for (double** piece : {&center_, &shift_, &t_, &dt_, &z_, &p_, &trial_, &lift_}) *piece = memory_.take(n);
}

void AugmentedLagrangian::run(ConeIteration& at, VelocityHessian& hessian, int max_outer, double first_weight) {
  hessian_ = &hessian;
  reserve(at.size());
  rho_ = first_weight;
  const Index n = at.size();
  center_at_iterate(at);
  y_.resize(2 * n);
  image_.resize(2 * n);
  last_error_ = std::numeric_limits<double>::infinity();
  double least_weight = last_weight;
  for (int outer = 0; outer < max_outer && !at.done(); ++outer) {
    if (!proximal_step(at)) {
      if (at.done()) return;
      least_weight = std::min(largest_weight, weight_growth * rho_);
      rho_ = least_weight;
      at.return_to(Iterate::best);
      center_at_iterate(at);
      continue;
    }
    const double error = std::max(prox_error_, shift_error_);
    bool restart = error > max_growth * last_error_;
    if (prox_error_ > max_shift_share * shift_error_ && rho_ > least_weight) {
      rho_ = std::max(weight_decay * rho_, least_weight);
      restart = true;
    }
    last_error_ = error;
    y_ << Eigen::Map<Eigen::VectorXd>(center_, n), Eigen::Map<Eigen::VectorXd>(shift_, n);
    image_ << at.x(), Eigen::Map<Eigen::VectorXd>(lift_, n);
    if (restart) acceleration_.start(2 * n);
    const AndersonAcceleration::Vector& next = acceleration_.next(y_, image_);
    std::copy_n(next.data(), n, center_);
    std::copy_n(next.data() + n, n, shift_);
  }
}

// The next proximal problem is that of the present iterate, and the acceleration starts again.
void AugmentedLagrangian::center_at_iterate(ConeIteration& at) {
  const Index n = at.size();
  std::copy_n(at.x().data(), n, center_);
  set_lift(at, shift_);
  acceleration_.start(2 * n);
}

// out <- s(u) of the present iterate; 0 in a convex problem.
void AugmentedLagrangian::set_lift(ConeIteration& at, double* out) const {
  std::fill_n(out, at.size(), 0.0);
  if (at.exact()) add_lift(at.cones(), at.u().data(), out);
}

bool AugmentedLagrangian::proximal_step(ConeIteration& at) {
  const Index n = at.size();
  hessian_->multiply(at.x().data(), w_);
  hessian_->multiply_transposed(w_, t_);
  for (Index i = 0; i < n; ++i) z_[i] = center_[i] - (t_[i] + at.b()[i] + shift_[i]) / rho_;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0, least_at = 0; k - least_at < patience; ++k) {
    evaluate(at);
    if (!at.advance()) return false;
    // The error that remains in this proximal problem, and what the next one will change.
    double inner = 0, outer = 0;
    prox_error_ = shift_error_ = 0;
    set_lift(at, lift_);
    for (Index i = 0; i < n; ++i) {
      inner = std::max(inner, std::abs(t_[i] + at.b()[i] - at.u()[i]));
      prox_error_ = std::max(prox_error_, rho_ * std::abs(p_[i] - center_[i]));
      shift_error_ = std::max(shift_error_, std::abs(lift_[i] - shift_[i]));
      outer = std::max(prox_error_, shift_error_);
    }
    if (inner <= inner_fraction * outer) return true;
    if (inner < least) {
      least = inner;
      least_at = k;
    }
    linearize(at);
    if (!hessian_->factorize(at.cones(), modes_, weights_)) return false;
    hessian_->solve(g_, dw_);
    dw_ = -dw_;
    hessian_->multiply_transposed(dw_, dt_);
    const double length = line_search(at);
    w_ += length * dw_;
    for (Index i = 0; i < n; ++i) {
      t_[i] += length * dt_[i];
      z_[i] -= length * dt_[i] / rho_;
    }
  }
  return false;
}

void AugmentedLagrangian::linearize(ConeIteration& at) {
  const std::span<const Cone> cones = at.cones();
  modes_.resize(cones.size());
  weights_.resize(cones.size());
  for (std::size_t i = 0; i < cones.size(); ++i) {
    projection_modes(cones[i], z_ + cones[i].first, modes_[i]);
    for (std::size_t k = 0; k < Cone::max_size; ++k) weights_[i][k] = modes_[i].lambda[k] / rho_;
  }
}

// x = P_K(z), u = G x + b and the gradient g = w - W x of psi at w.
void AugmentedLagrangian::evaluate(ConeIteration& at) {
  at.project_all(z_, p_);
  hessian_->multiply(p_, g_);
  std::copy_n(p_, at.size(), at.x().data());
  hessian_->multiply_transposed(g_, at.u().data());
  at.u() += at.b();
  at.count_product();
  g_ = w_ - g_;
}

// d psi(w + length dw) / d length
double AugmentedLagrangian::derivative(ConeIteration& at, double length) {
  const Index n = at.size();
  for (Index i = 0; i < n; ++i) trial_[i] = z_[i] - length * dt_[i] / rho_;
  at.project_all(trial_, trial_);
  double sum = w_.dot(dw_) + length * dw_.squaredNorm();
  for (Index i = 0; i < n; ++i) sum -= trial_[i] * dt_[i];
  return sum;
}

// The length of the step: 1, or near the minimum along it if that is shorter.
double AugmentedLagrangian::line_search(ConeIteration& at) {
  const double start = g_.dot(dw_);
  double low = 0, at_low = start, high = 1, at_high = derivative(at, 1);
  if (at_high <= curvature_fraction * std::abs(start)) return 1;
  double length = 1;
  for (int k = 0; k < max_trials; ++k) {
    length = low + (high - low) * std::clamp(at_low / (at_low - at_high), 0.05, 0.95);
    const double value = derivative(at, length);
    if (std::abs(value) <= curvature_fraction * std::abs(start)) break;
    (value < 0 ? low : high) = length;
    (value < 0 ? at_low : at_high) = value;
  }
  return length;
}

}  // namespace gelenk
