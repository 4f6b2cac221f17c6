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

// L <- the Cholesky factor of the products, from the newest difference on; zero pivots of those that say nothing.
void AndersonAcceleration::factorize() {
  for (Index i = 0; i < count_; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double left = products_(place(i), place(j)) - L_.row(i).head(j).dot(L_.row(j).head(j));
      L_(i, j) = L_(j, j) > 0 ? left / L_(j, j) : 0;
    }
    const double square = products_(place(i), place(i));
    const double left = square - L_.row(i).head(i).squaredNorm();
    L_(i, i) = left > min_square * square ? std::sqrt(left) : 0;
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
  factorize();
  Eigen::Matrix<double, depth, 1> weights = Eigen::Matrix<double, depth, 1>::Zero();
  for (Index i = 0; i < count_; ++i) {
    const double left = residuals_.col(place(i)).dot(residual_) - L_.row(i).head(i).dot(weights.head(i));
    weights[i] = L_(i, i) > 0 ? left / L_(i, i) : 0;
  }
  for (Index i = count_ - 1; i >= 0; --i) {
    const Index after = count_ - i - 1;
    const double left = weights[i] - L_.col(i).segment(i + 1, after).dot(weights.segment(i + 1, after));
    weights[i] = L_(i, i) > 0 ? left / L_(i, i) : 0;
    next_ -= weights[i] * images_.col(place(i));
  }
  return next_;
}

}  // namespace gelenk
