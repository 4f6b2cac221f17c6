// SPDX-License-Identifier: BSD-3-Clause
// Which speeds of a mechanism may stand for all, by its rows.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "analysis/mobility.h"

namespace gelenk {

// Columns of J (rows x nv) that may serve as independent ones: nv - rank of them. prefer[k]: wanted among them.
std::vector<int> independent_columns(const Eigen::SparseMatrix<double>& J, int rank, const std::vector<bool>& prefer);

// Where `dynamics` stands; wanted among them where that is possible, by speed.
Independent independent_at(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                           const std::vector<bool>& coordinates, const std::vector<bool>& speeds);

}  // namespace gelenk
