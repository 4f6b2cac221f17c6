// SPDX-License-Identifier: BSD-3-Clause
// Anderson's acceleration of a fixed-point iteration y <- F(y) (Anderson 1965; Walker & Ni 2011): the next y is the
// combination of the last images whose combined residual F(y) - y is least.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

class AndersonAcceleration {
 public:
  using Vector = Eigen::Map<Eigen::VectorXd>;

  // Forgets the history. n: numbers of y. Allocates nothing if n is no larger than before.
  void start(Eigen::Index n);
  // image: F(y). Returns the next y.
  const Vector& next(const Eigen::Ref<const Eigen::VectorXd>& y, const Eigen::Ref<const Eigen::VectorXd>& image);

 private:
  using Matrix = Eigen::Map<Eigen::MatrixXd>;
  void keep(const Eigen::Ref<const Eigen::VectorXd>& image);
  void factorize();
  Eigen::Index place(Eigen::Index i) const { return (newest_ - i + depth) % depth; }  // of the i-th newest difference

  static constexpr Eigen::Index depth = 8;

  Eigen::Index count_ = 0;  // differences that are kept, at most depth
  Eigen::Index newest_ = 0;
  bool has_last_ = false;
  std::vector<double> numbers_;  // of all that follow
  Vector residual_{nullptr, 0}, last_residual_{nullptr, 0}, last_image_{nullptr, 0}, next_{nullptr, 0};
  Matrix residuals_{nullptr, 0, 0}, images_{nullptr, 0, 0};  // differences from one iterate to the next, in columns
  Eigen::Matrix<double, depth, depth> products_;             // of residuals_ with each other
  Eigen::Matrix<double, depth, depth> L_;
};

}  // namespace gelenk
