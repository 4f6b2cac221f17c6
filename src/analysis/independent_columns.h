// SPDX-License-Identifier: BSD-3-Clause
// Which speeds of a mechanism may stand for all, by its rows.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace gelenk {

// Columns of J (rows x nv) that may serve as independent ones: nv - rank of them. prefer[k]: wanted among them.
std::vector<int> independent_columns(const Eigen::SparseMatrix<double>& J, int rank, const std::vector<bool>& prefer);

}  // namespace gelenk
