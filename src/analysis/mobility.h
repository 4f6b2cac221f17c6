// SPDX-License-Identifier: BSD-3-Clause
// Mobility analysis: the degrees of freedom of a mechanism over its range of motion, its redundant constraints, its
// immobile joints, and its independent velocities.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cmath>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

struct MobilityAnalysis {
  int rank = 0;           // of the constraint Jacobian at positions without special symmetry
  int rank_start = 0;     // at q; less if the start is singular
  int position_rank = 0;  // of the constraint equations that hold positions
  // The largest ratio of smallest to largest pivot among the positions visited (row_factor.h). Infinite: the
  // constraints leave a motion free at q, but no other closed position was found, so that q is singular (rigid, though
  // not at first order).
  double best_pivot_ratio = 0;
  // The same; 0: not known.
  double known_pivot_ratio() const { return std::isfinite(best_pivot_ratio) ? best_pivot_ratio : 0; }
  // Constraints are redundant at q, judged by the pivots, and no other closed position was found: the redundant ones
  // contradict the others.
  bool stuck = false;
  // For each cut, its constraint equations (Cut::kept) that are needed. The others are combinations of these with
  // constant coefficients, so that omitting them changes nothing at any position, singular ones included. Constraints
  // that are redundant with coefficients that depend on the position are kept: each of them is needed somewhere.
  std::vector<std::vector<int>> needed;
  int needed_rows = 0;
  std::vector<bool> immobile_links;  // by link: its joint has velocities, but none of them can ever be nonzero
  std::vector<bool> immobile_cuts;
  // Multipliers that do no work, one column for each redundant constraint (rows x (rows - rank)), at a position without
  // special symmetry, generic_q: these constraint forces are undetermined for rigid bodies.
  Eigen::MatrixXd null_multipliers;
  std::vector<double> generic_q;
};

// Explores closed positions from the closed position q along free motions: first in the direction in which the
// mechanism sets out (initial_direction: nv velocities or accelerations; empty: unknown), then in random directions.
// Leaves `dynamics` at q and its set_max_rank() at the rank.
MobilityAnalysis analyze_mobility(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                  const std::vector<double>& initial_direction);

// The same for a mechanism with time-dependent constraints: analyzed without them first, then for what they leave free.
// dynamics: of `mechanism`, left at q; free: of without_drives(mechanism).
MobilityAnalysis analyze_driven_mobility(const Mechanism& mechanism, Dynamics& dynamics,
                                         const Mechanism& free_mechanism, Dynamics& free, const std::vector<double>& q,
                                         const std::vector<double>& initial_direction);

// Indices of the independent velocities and of the velocities with independent coordinates, which are more if there are
// nonholonomic constraints.
struct Independent {
  std::vector<int> coordinates, speeds;
};

// J with all rows set to 0 that do not hold positions.
Eigen::SparseMatrix<double> position_rows(const Mechanism& mechanism, Eigen::SparseMatrix<double> J);

}  // namespace gelenk
