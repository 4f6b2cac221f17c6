// SPDX-License-Identifier: BSD-3-Clause
// Conversion between derivative components of dual numbers or series and columns of matrices.
#pragma once

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "math/dual.h"

namespace gelenk {

template <class Numbers>
Eigen::VectorXd derivatives_along(const Numbers& from, int k) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(from.size()));
  for (std::size_t i = 0; i < from.size(); ++i) {
    if constexpr (std::is_same_v<typename Numbers::value_type, Dual>) {
      out[static_cast<Eigen::Index>(i)] = from[i].derivatives()[k];
    } else {
      out[static_cast<Eigen::Index>(i)] = from[i][k];
    }
  }
  return out;
}

inline Eigen::MatrixXd derivative_columns(const std::vector<Dual>& from, Eigen::Index n) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(from.size()), n);
  for (Eigen::Index k = 0; k < n; ++k) out.col(k) = derivatives_along(from, static_cast<int>(k));
  return out;
}

inline void set_derivatives(const Eigen::MatrixXd& from, std::vector<Dual>& to) {
  for (Eigen::Index i = 0; i < from.rows(); ++i) {
    to[i].derivatives().setZero();
    for (Eigen::Index k = 0; k < from.cols(); ++k) to[i].derivatives()[k] = from(i, k);
  }
}

// out += A x with the first `rows` entries of x, many of which may be zero.
template <class From, class X, class To>
void add_product(const From& A, const X& x, Eigen::Index rows, To& out) {
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    for (Eigen::Index j = 0; j < rows; ++j) {
      const double factor = x(j, k);
      if (factor != 0) out.col(k) += factor * A.col(j);
    }
  }
}

template <class T>
void set_values(const Eigen::VectorXd& from, std::vector<T>& to) {
  for (Eigen::Index i = 0; i < from.size(); ++i) to[i] = T(from[i]);
}

}  // namespace gelenk
