// SPDX-License-Identifier: BSD-3-Clause
// What the rows of a mechanism leave free, everywhere it can go: how many freedoms it has, which rows only repeat
// others, which joints cannot move, and which speeds may stand for all.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

struct MobilityAnalysis {
  int rank = 0;           // of the rows, at positions without special symmetry
  int rank_start = 0;     // at q; less where the start is singular
  int position_rank = 0;  // of the rows that hold positions
  // The largest ratio of smallest to largest pivot among the positions seen (row_factor.h). Infinite: the rows leave a
  // motion free at q, but no other position closes, so that q is singular (rigid, though not at first order).
  double best_pivot_ratio = 0;
  // Rows are redundant at q, as far as pivots tell, and no other position closes: the redundant ones contradict the
  // others.
  bool stuck = false;
  // By cut, those of its rows (Cut::kept) that are needed. The others are combinations of these with constant factors,
  // so that leaving them out changes nothing at any position, singular ones included. Rows that repeat
  // others with factors that change with the position stay: each of them is needed somewhere.
  std::vector<std::vector<int>> needed;
  int needed_rows = 0;
  std::vector<bool> immobile_links;  // by link: its joint has speeds, but none of them can ever move
  std::vector<bool> immobile_cuts;
  // Multipliers that do no work, one column for each redundant row (rows x (rows - rank)), at a position without
  // special symmetry, idle_q: what they hold, rigid bodies leave undetermined.
  Eigen::MatrixXd null_multipliers;
  std::vector<double> generic_q;
};

// From q, closed, along free motions to several other closed positions: first the way the mechanism sets out (nv speeds
// or accelerations; empty: unknown), then at random. Leaves `dynamics` at q and dynamics.set_max_rank at the rank.
MobilityAnalysis analyze_mobility(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                  const std::vector<double>& way);

// The same of a mechanism with rows that change with time: what it is without them, and then how much is left.
// dynamics: of `mechanism`, left at q; free: of without_drives(mechanism).
MobilityAnalysis analyze_driven_mobility(const Mechanism& mechanism, Dynamics& dynamics,
                                         const Mechanism& free_mechanism, Dynamics& free, const std::vector<double>& q,
                                         const std::vector<double>& way);

// Which speeds of a mechanism are independent, and which have independent coordinates: more, where rows hold speeds
// only.
struct Independent {
  std::vector<int> coordinates, speeds;
};

// J's rows that hold positions; the others 0.
Eigen::SparseMatrix<double> position_rows(const Mechanism& mechanism, Eigen::SparseMatrix<double> J);

}  // namespace gelenk
