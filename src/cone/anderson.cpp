// SPDX-License-Identifier: BSD-3-Clause
#include "cone/anderson.h"

#include <algorithm>

namespace gelenk {

using Eigen::Index;

namespace {
constexpr double min_angle = 1e-8;  // sine of the angle of a difference to those before it, below which it says nothing
}

void AndersonAcceleration::start(Index n) {
  count_ = 0;
  newest_ = -1;
  has_last_ = false;
  residuals_.resize(n, depth);
  images_.resize(n, depth);
  basis_.resize(n, depth);
  combined_.resize(n, depth);
}

const Eigen::VectorXd& AndersonAcceleration::next(const Eigen::VectorXd& y, const Eigen::VectorXd& image) {
  residual_ = image - y;
  if (has_last_) {
    newest_ = (newest_ + 1) % depth;
    count_ = std::min(count_ + 1, depth);
    residuals_.col(newest_) = residual_ - last_residual_;
    images_.col(newest_) = image - last_image_;
  }
  has_last_ = true;
  last_residual_ = residual_;
  last_image_ = image;
  next_ = image;
  // Gram-Schmidt from the newest difference on; the images are combined like the residuals.
  for (Index i = 0; i < count_; ++i) {
    const Index k = (newest_ - i + depth) % depth;
    auto q = basis_.col(i);
    auto p = combined_.col(i);
    q = residuals_.col(k);
    p = images_.col(k);
    const double length = q.norm();
    for (int pass = 0; pass < 2; ++pass) {
      for (Index j = 0; j < i; ++j) {
        const double along = basis_.col(j).dot(q);
        q -= along * basis_.col(j);
        p -= along * combined_.col(j);
      }
    }
    const double left = q.norm();
    if (!(left > min_angle * length)) {
      q.setZero();
      p.setZero();
      continue;
    }
    q /= left;
    p /= left;
    next_ -= q.dot(residual_) * p;
  }
  return next_;
}

}  // namespace gelenk
