// SPDX-License-Identifier: BSD-3-Clause
// Factorizations in place, without allocation: Eigen's allocate work space for large matrices.
#pragma once

#include "cone/iteration.h"

namespace gelenk {

// A = L D L^T of a symmetric positive definite A, of which only the lower triangle is used. Pivots below least_pivot,
// which rounding leaves of singular matrices, are replaced by it.
void factorize_symmetric(ConeMatrix A, double least_pivot);
// x <- A^-1 x
void solve_symmetric(const ConeMatrix& A, ConeVector x);

// P A = L U with row pivoting; pivots: A.rows() numbers. Pivots smaller than least_pivot are replaced by it.
void factorize_general(ConeMatrix A, int* pivots, double least_pivot);
void solve_general(const ConeMatrix& A, const int* pivots, ConeVector x);

}  // namespace gelenk
