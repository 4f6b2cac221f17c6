// SPDX-License-Identifier: BSD-3-Clause
// Choice of independent velocities and coordinates of a mechanism from its constraint Jacobian.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "analysis/mobility.h"

namespace gelenk {

// Selects nv - rank columns of J (rows x nv) as independent ones, if possible those with prefer[k].
std::vector<int> independent_columns(const Eigen::SparseMatrix<double>& J, int rank, const std::vector<bool>& prefer);

// Independent coordinates and velocities at the present position of `dynamics`, if possible the preferred ones (flags
// by velocity).
Independent independent_at(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                           const std::vector<bool>& coordinates, const std::vector<bool>& speeds);

}  // namespace gelenk
