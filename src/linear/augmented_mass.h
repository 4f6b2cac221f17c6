// SPDX-License-Identifier: BSD-3-Clause
// The augmented mass matrix M + J^T S J, with a positive diagonal S. It is positive definite if M is positive definite
// on the null space of J, even if M alone is singular. With J vdot = gamma the equations of motion read
//
//   (M + J^T S J) vdot + J^T lambda = f + J^T S gamma
//
// with the same vdot and the same lambda (Benzi, Golub & Liesen 2005).
// The projection in the metric of the augmented matrix is the same, too: on the constraints the added term is constant.
#pragma once

#include <vector>

#include "linear/sparse_factor.h"
#include "linear/sparse_rows.h"

namespace gelenk {

class AugmentedMass {
 public:
  // Inertias below this fraction of the largest are rounding: an error of 1e-16 in the position of a point mass leaves
  // this moment of inertia about an axis through it.
  static constexpr double inertia_threshold = 1e-26;

  // parent: of the velocities in the tree (SparseFactor). J must outlive this object.
  AugmentedMass(const std::vector<int>& parent, const SparseRows& J);

  // The sparsity pattern of the augmented matrix, as parents for SparseFactor.
  std::vector<int> pattern() const;
  // M; to be filled in before assemble().
  SparseFactor& M() { return M_; }
  const SparseFactor& M() const { return M_; }

  // sum, with the pattern of pattern(), <- M + J^T S J with the current J.
  void assemble(SparseFactor& sum);
  // Factorizes the result of assemble(). False: singular; massless_motion() is then a motion without inertia.
  bool factorize(SparseFactor& sum);
  const std::vector<double>& massless_motion() const { return massless_motion_; }

  // f += J^T S gamma with S of the last assemble(), for each column of f (nv x columns) and gamma (rows x columns).
  void add_right_side(const double* gamma, double* f, int columns = 1) const;

 private:
  void choose_scales();

  SparseFactor M_;
  const SparseRows& J_;
  std::vector<double> scale_;     // S
  std::vector<double> diagonal_;  // of the augmented matrix
  std::vector<double> massless_motion_;
};

}  // namespace gelenk
