// SPDX-License-Identifier: BSD-3-Clause
// Accelerations, as expressions. Velocities are divided into dependent ones, as many as there are independent
// constraint equations, and independent ones: v_d = -J_d^-1 J_i v_i + ..., with pivots that are chosen where the
// equations are recorded and remain the same. The null space of J is used rather than (J M^-1 J^T)^-1: it needs fewer
// operations, is more accurate, and right where equations are redundant.
#pragma once

#include <vector>

#include "recorded/motion_terms.h"
#include "recorded/pivots.h"
#include "recording/recorded.h"

namespace gelenk {

class Elimination {
 public:
  using Numbers = std::vector<recording::Recorded>;
  // Records in the present Recording, of which the graph is a copy of that of the equations.
  Elimination(const EquationTerms& equations, const Pivots& pivots);

  // vdot, from gamma by row of the pivots and h.
  Numbers accelerations(const Numbers& gamma, const Numbers& h) const;
  // The smallest displacement in the mass metric that removes residuals of the rows.
  Numbers displacement(const Numbers& residual) const;
  // The reciprocals of the pivots of J, and of those of the reduced mass matrix.
  const Numbers& reciprocal_pivots() const { return reciprocal_; }
  const Numbers& reciprocal_masses() const { return reciprocal_mass_; }
  // The independent velocities, in the order of these.
  const std::vector<int>& free() const { return free_; }

 private:
  using Matrix = std::vector<Numbers>;

  void factorize_constraints(const EquationTerms& equations);
  void factorize_mass(const EquationTerms& equations);
  Numbers dependent(Numbers right_side) const;    // J_d x = right side
  Numbers independent(Numbers right_side) const;  // T^T M T x = right side
  Numbers whole(const Numbers& particular, const Numbers& free) const;

  Pivots pivots_;
  std::vector<int> free_;  // the independent velocities
  int nv_;
  Matrix LU_;    // of J_d
  Matrix T_;     // dependent by independent
  Matrix TM_d_;  // T^T M, columns of dependent velocities
  Matrix L_;     // of T^T M T = L^T D L
  Numbers reciprocal_, reciprocal_mass_;
};

}  // namespace gelenk
