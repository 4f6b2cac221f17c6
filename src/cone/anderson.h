// SPDX-License-Identifier: BSD-3-Clause
// Anderson's acceleration of a fixed-point iteration y <- F(y) (Anderson 1965; Walker & Ni 2011): the next y is the
// combination of the last images whose combined residual F(y) - y is least.
#pragma once

#include <Eigen/Core>

namespace gelenk {

class AndersonAcceleration {
 public:
  // Forgets the history. n: numbers of y.
  void start(Eigen::Index n);
  // image: F(y). Returns the next y.
  const Eigen::VectorXd& next(const Eigen::VectorXd& y, const Eigen::VectorXd& image);

 private:
  static constexpr Eigen::Index depth = 6;

  Eigen::Index count_ = 0;  // differences that are kept, at most depth
  Eigen::Index newest_ = 0;
  bool has_last_ = false;
  Eigen::VectorXd residual_, last_residual_, last_image_, next_;
  Eigen::MatrixXd residuals_, images_;  // differences from one iterate to the next, in columns
  Eigen::MatrixXd basis_, combined_;    // orthonormal residuals, and the same combinations of images
};

}  // namespace gelenk
