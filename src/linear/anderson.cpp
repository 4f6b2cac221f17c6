// SPDX-License-Identifier: BSD-3-Clause
#include "linear/anderson.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Index;

namespace {
// Square of the sine of the angle of a difference to those before it, below which it says nothing.
constexpr double min_square = 1e-13;
}  // namespace

void AndersonAcceleration::start(Index n) {
  count_ = 0;
  newest_ = -1;
  has_last_ = false;
  const auto size = static_cast<std::size_t>((4 + 2 * depth) * n);
  if (numbers_.size() < size) numbers_.resize(size);
  double* at = numbers_.data();
  for (Vector* vector : {&residual_, &last_residual_, &last_image_, &next_}) {
    new (vector) Vector(at, n);
    at += n;
  }
  for (Matrix* matrix : {&residuals_, &images_}) {
    new (matrix) Matrix(at, n, depth);
    at += depth * n;
  }
}

// Replaces the oldest difference, with its products with all others.
void AndersonAcceleration::keep(const Eigen::Ref<const Eigen::VectorXd>& image) {
  newest_ = (newest_ + 1) % depth;
  count_ = std::min(count_ + 1, depth);
  residuals_.col(newest_) = residual_ - last_residual_;
  images_.col(newest_) = image - last_image_;
  for (Index k = 0; k < count_; ++k) {
    products_(k, newest_) = products_(newest_, k) = residuals_.col(k).dot(residuals_.col(newest_));
  }
}

const AndersonAcceleration::Vector& AndersonAcceleration::next(const Eigen::Ref<const Eigen::VectorXd>& y,
                                                               const Eigen::Ref<const Eigen::VectorXd>& image) {
  residual_ = image - y;
  if (has_last_) keep(image);
  has_last_ = true;
  last_residual_ = residual_;
  last_image_ = image;
  next_ = image;
  // The normal equations by Cholesky's method, from the newest difference on.
  Eigen::Matrix<double, depth, depth> L;
  Eigen::Matrix<double, depth, 1> weights = Eigen::Matrix<double, depth, 1>::Zero();
  const auto place = [&](Index i) { return (newest_ - i + depth) % depth; };
  for (Index i = 0; i < count_; ++i) {
    for (Index j = 0; j <= i; ++j) {
      double left = products_(place(i), place(j));
      for (Index k = 0; k < j; ++k) left -= L(i, k) * L(j, k);
      if (j < i) {
        L(i, j) = L(j, j) > 0 ? left / L(j, j) : 0;
      } else {
        L(i, i) = left > min_square * products_(place(i), place(i)) ? std::sqrt(left) : 0;
      }
    }
    double left = residuals_.col(place(i)).dot(residual_);
    for (Index k = 0; k < i; ++k) left -= L(i, k) * weights[k];
    weights[i] = L(i, i) > 0 ? left / L(i, i) : 0;
  }
  for (Index i = count_ - 1; i >= 0; --i) {
    for (Index k = i + 1; k < count_; ++k) weights[i] -= L(k, i) * weights[k];
    weights[i] = L(i, i) > 0 ? weights[i] / L(i, i) : 0;
    next_ -= weights[i] * images_.col(place(i));
  }
  return next_;
}

}  // namespace gelenk
