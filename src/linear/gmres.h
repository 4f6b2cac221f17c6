// SPDX-License-Identifier: BSD-3-Clause
// GMRES (Saad & Schultz 1986) without restarts, for operators that are given as a function.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace gelenk {

class Gmres {
 public:
  // Solves A x = b from x = 0 until |A x - b| <= tolerance |b|, or with max_steps products. apply(in, out): out <- A
  // in. Returns the number of products.
  template <class Apply>
  int solve(const Apply& apply, const Eigen::VectorXd& b, double tolerance, int max_steps, Eigen::VectorXd& x);

 private:
  // Makes column k of the Hessenberg matrix triangular, and the residual's component k + 1.
  void rotate(Eigen::Index k);

  Eigen::MatrixXd V_, R_;  // Krylov basis, by columns; triangular factor
  Eigen::VectorXd g_, cos_, sin_, work_;
};

template <class Apply>
int Gmres::solve(const Apply& apply, const Eigen::VectorXd& b, double tolerance, int max_steps, Eigen::VectorXd& x) {
  using Eigen::Index;
  x.setZero(b.size());
  const double start = b.norm();
  if (!(start > 0) || !std::isfinite(start)) return 0;
  V_.resize(b.size(), max_steps + 1);
  R_.setZero(max_steps + 1, max_steps);
  g_.setZero(max_steps + 1);
  cos_.resize(max_steps);
  sin_.resize(max_steps);
  V_.col(0) = b / start;
  g_[0] = start;
  Index steps = 0;
  while (steps < max_steps && std::abs(g_[steps]) > tolerance * start) {
    const Index k = steps++;
    work_ = V_.col(k);
    apply(work_, x);
    for (Index i = 0; i <= k; ++i) {
      R_(i, k) = V_.col(i).dot(x);
      x -= R_(i, k) * V_.col(i);
    }
    R_(k + 1, k) = x.norm();
    if (!(R_(k + 1, k) > 0)) {  // solved exactly
      rotate(k);
      break;
    }
    V_.col(k + 1) = x / R_(k + 1, k);
    rotate(k);
  }
  const auto R = R_.topLeftCorner(steps, steps).template triangularView<Eigen::Upper>();
  x = V_.leftCols(steps) * R.solve(g_.head(steps)).eval();
  return static_cast<int>(steps);
}

inline void Gmres::rotate(Eigen::Index k) {
  for (Eigen::Index i = 0; i < k; ++i) {
    const double upper = R_(i, k);
    R_(i, k) = cos_[i] * upper + sin_[i] * R_(i + 1, k);
    R_(i + 1, k) = cos_[i] * R_(i + 1, k) - sin_[i] * upper;
  }
  const double length = std::hypot(R_(k, k), R_(k + 1, k));
  cos_[k] = length > 0 ? R_(k, k) / length : 1;
  sin_[k] = length > 0 ? R_(k + 1, k) / length : 0;
  R_(k, k) = length;
  R_(k + 1, k) = 0;
  g_[k + 1] = -sin_[k] * g_[k];
  g_[k] = cos_[k] * g_[k];
}

}  // namespace gelenk
