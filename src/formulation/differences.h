// SPDX-License-Identifier: BSD-3-Clause
// Derivatives by differences, for Newton's methods, which need no exact ones.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace gelenk {

// Called after each evaluation beside y, with the index of what has been changed, and by how much.
using DifferenceTaken = std::function<void(Eigen::Index k, double step)>;
// Writes the last rows of df/dy, from the first row on, to `out`. f(y, fy) returns false where it is not defined; it is
// evaluated at y last. fy: its value at y, or null. Returns false if it has not been defined everywhere.
bool differentiate(const std::function<bool(const double* y, double* fy)>& f, const double* y, const double* fy,
                   Eigen::Index first_row, Eigen::Ref<Eigen::MatrixXd> out, const DifferenceTaken& taken = {});

}  // namespace gelenk
