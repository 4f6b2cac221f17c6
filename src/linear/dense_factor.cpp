// SPDX-License-Identifier: BSD-3-Clause
#include "linear/dense_factor.h"

#include <cmath>
#include <utility>
#include <vector>

namespace gelenk {

using Eigen::Index;

void lower_product(const Eigen::MatrixXd& C, Eigen::MatrixXd& A) {
  const Index n = C.rows();
  A.setZero();
  std::vector<Index> nonzeros(static_cast<std::size_t>(n));
  for (Index j = 0; j < C.cols(); ++j) {
    const double* c = C.data() + j * n;
    std::size_t count = 0;
    for (Index i = 0; i < n; ++i) {
      if (c[i] != 0) nonzeros[count++] = i;
    }
    for (std::size_t k = 0; k < count; ++k) {
      double* column = A.data() + nonzeros[k] * n;
      for (std::size_t i = k; i < count; ++i) column[nonzeros[i]] += c[nonzeros[k]] * c[nonzeros[i]];
    }
  }
}

void factorize_symmetric(DenseMatrix A, double least_pivot) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    if (!(A(j, j) >= least_pivot)) A(j, j) = least_pivot;
    const double inverse = 1 / A(j, j);
    const Index below = n - j - 1;
    double* column = &A(j, j) + 1;
    for (Index c = 0; c < below; ++c) {
      const double factor = column[c] * inverse;
      if (factor == 0) continue;
      double* target = &A(j + 1 + c, j + 1 + c);
      const double* source = column + c;
      for (Index i = 0; i < below - c; ++i) target[i] -= factor * source[i];
    }
    for (Index i = 0; i < below; ++i) column[i] *= inverse;
  }
}

void solve_symmetric(const DenseMatrix& A, DenseVector x) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    const double value = x[j];
    for (Index i = j + 1; i < n; ++i) x[i] -= A(i, j) * value;
  }
  for (Index j = n - 1; j >= 0; --j) {
    double sum = x[j] / A(j, j);
    for (Index i = j + 1; i < n; ++i) sum -= A(i, j) * x[i];
    x[j] = sum;
  }
}

namespace {

// Exchanges row j with that of the largest entry below the diagonal of column j; returns the latter's number.
Index exchange_rows(DenseMatrix& A, Index j) {
  Index pivot = j;
  for (Index i = j + 1; i < A.rows(); ++i) {
    if (std::abs(A(i, j)) > std::abs(A(pivot, j))) pivot = i;
  }
  if (pivot != j) {
    for (Index c = 0; c < A.cols(); ++c) std::swap(A(j, c), A(pivot, c));
  }
  return pivot;
}

}  // namespace

void factorize_general(DenseMatrix A, int* pivots, double least_pivot) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    pivots[j] = static_cast<int>(exchange_rows(A, j));
    if (!(std::abs(A(j, j)) >= least_pivot)) A(j, j) = A(j, j) < 0 ? -least_pivot : least_pivot;
    const double inverse = 1 / A(j, j);
    double* column = &A(j, j) + 1;
    const Index below = n - j - 1;
    for (Index i = 0; i < below; ++i) column[i] *= inverse;
    for (Index c = j + 1; c < n; ++c) {
      const double factor = A(j, c);
      double* target = &A(j, c) + 1;
      for (Index i = 0; i < below; ++i) target[i] -= factor * column[i];
    }
  }
}

bool has_positive_determinant(const DenseMatrix& A, const int* pivots) {
  bool is_positive = true;
  for (Index j = 0; j < A.rows(); ++j) is_positive = is_positive == ((A(j, j) > 0) == (pivots[j] == j));
  return is_positive;
}

void solve_general(const DenseMatrix& A, const int* pivots, DenseVector x) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    if (pivots[j] != j) std::swap(x[j], x[pivots[j]]);
  }
  for (Index j = 0; j < n; ++j) {
    const double value = x[j];
    for (Index i = j + 1; i < n; ++i) x[i] -= A(i, j) * value;
  }
  for (Index j = n - 1; j >= 0; --j) {
    x[j] /= A(j, j);
    const double value = x[j];
    for (Index i = 0; i < j; ++i) x[i] -= A(i, j) * value;
  }
}

}  // namespace gelenk
