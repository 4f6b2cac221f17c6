// SPDX-License-Identifier: BSD-3-Clause
// M + J^T S J, S a positive diagonal: positive definite where M is so along all motions that the rows J leave, though
// M alone may be singular. With J vdot = gamma the equations of motion read
//
//   (M + J^T S J) vdot + J^T lambda = f + J^T S gamma
//
// with the same vdot and the same lambda (Benzi, Golub & Liesen 2005).
// The least change onto the rows is the same, too: along them the term added is what the rows ask for.
#pragma once

#include <vector>

#include "linear/sparse_factor.h"
#include "linear/sparse_rows.h"

namespace gelenk {

class JoinedMass {
 public:
  // Of the largest moment: less is what rounding of a position, 1e-16, leaves of a moment about an axis through it.
  static constexpr double no_inertia = 1e-26;

  // parent: of the speeds on the tree (SparseFactor). J: outlives it.
  JoinedMass(const std::vector<int>& parent, const SparseRows& J);

  // The pattern of the sum, as parents for SparseFactor.
  std::vector<int> pattern() const;
  // To be filled with M before join().
  SparseFactor& tree() { return tree_; }
  const SparseFactor& tree() const { return tree_; }

  // sum, of pattern(), <- M + J^T S J, J as it is now.
  void join(SparseFactor& sum);
  // Factorises what join() has left. False: without_inertia() is a motion that has none.
  bool factorize(SparseFactor& sum);
  const std::vector<double>& without_inertia() const { return motion_; }

  // f += J^T S gamma, of the last join(); and for the columns of f (speeds x columns) and gamma (rows x columns).
  void add(const double* gamma, double* f, int columns = 1) const;

 private:
  void choose_scales();

  SparseFactor tree_;
  const SparseRows& J_;
  std::vector<double> scale_;     // S
  std::vector<double> diagonal_;  // of the sum
  std::vector<double> motion_;
};

}  // namespace gelenk
