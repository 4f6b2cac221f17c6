// SPDX-License-Identifier: BSD-3-Clause
// What the rows of a mechanism leave free, everywhere it can go: how many freedoms it has, which rows only repeat
// others, which joints cannot move, and which speeds may stand for all.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

struct Structure {
  int rank = 0;        // of the rows, at positions without special symmetry
  int rank_start = 0;  // at q; less where the start is singular
  // By cut, those of its rows (Cut::kept) that are needed. The others are combinations of these with constant factors,
  // so that leaving them out changes nothing at any position, singular ones included. Rows that repeat
  // others with factors that change with the position stay: each of them is needed somewhere.
  std::vector<std::vector<int>> needed;
  int needed_rows = 0;
  std::vector<bool> standing_links;  // by link: its joint has speeds, but none of them can ever move
  std::vector<bool> standing_cuts;
  // Multipliers that do no work, one column for each redundant row (rows x (rows - rank)), at a position without
  // special symmetry, idle_q: what they hold, rigid bodies leave undetermined.
  Eigen::MatrixXd idle;
  std::vector<double> idle_q;
};

// From q, closed, along free motions to several other closed positions: first the way the mechanism sets out (nv speeds
// or accelerations; empty: unknown), then at random. Leaves `dynamics` at q and dynamics.limit_rank at the rank.
Structure structure_of(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                       const std::vector<double>& way);

// Speeds that may serve as independent ones at q: nv - rank of them. prefer[k]: wanted among them.
std::vector<int> independent_speeds(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                    int rank, const std::vector<bool>& prefer);

}  // namespace gelenk
