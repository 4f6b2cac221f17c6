// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/dependent_unknowns.h"

#include <algorithm>
#include <array>

#include "analysis/constrained_sensitivity.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {

using Eigen::Index;
using Eigen::MatrixXd;

void DependentUnknowns::compute(const MatrixXd& J, int rank) {
  if (static_cast<int>(dependent.size()) != rank) throw NotDifferentiablePoint(NotDifferentiablePoint::What::partition);
  if (rank == 0) return;
  factor.compute(J(rows, dependent));
  const auto pivots = factor.matrixQR().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > singular_pivot_ratio * pivots.maxCoeff()))
    throw NotDifferentiablePoint(NotDifferentiablePoint::What::partition);
}

MatrixXd DependentUnknowns::solve(const MatrixXd& residuals, Index nv) const {
  MatrixXd out = MatrixXd::Zero(nv, residuals.cols());
  if (!dependent.empty()) out(dependent, Eigen::all) = -factor.solve(residuals(rows, Eigen::all));
  return out;
}

MatrixXd changes_of_targets(const Mechanism& mechanism, const Loads& loads, const double* u, int order,
                            const MatrixXd& du) {
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(mechanism.coordinate_rows.size()), du.cols());
  for (std::size_t i = 0; i < mechanism.coordinate_rows.size(); ++i) {
    const CoordinateRow& row = mechanism.coordinate_rows[i];
    const auto r = static_cast<Index>(i);
    row.for_inputs([&](int input, int of) {
      if (of == order) out.row(r) = du.row(input);
    });
    if (!row.follows_signals) continue;
    const Formula& target = loads.motions[i][static_cast<std::size_t>(order)];
    if (!target.is_given()) continue;
    for (std::size_t k = 0; k < target.signals().size(); ++k) {
      std::array<Dual, Formula::max_signals> signals;
      std::ranges::transform(target.signals(), signals.begin(), [&](int signal) { return Dual(u[signal]); });
      signals[k].derivatives()[0] = 1;
      out.row(r) += target.value<Dual>(nullptr, signals.data()).derivatives()[0] * du.row(target.signals()[k]);
    }
  }
  return out;
}

}  // namespace gelenk
