// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/dependent_coordinates.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Smallest pivot over the largest, below which the independent coordinates count as not determining the others: errors
// of closing the loops, 1e-14, would become larger than tolerances.
constexpr double least_pivot_ratio = 1e-6;

}  // namespace

DependentCoordinates::DependentCoordinates(const Mechanism& mechanism, Dynamics& dynamics,
                                           const std::vector<int>& coordinates, const std::vector<int>& speeds)
    : ConstraintProjector(mechanism, dynamics),
      base_(static_cast<std::size_t>(mechanism.nq)),
      J_(mechanism.rows, mechanism.nv),
      x_(mechanism.nv),
      residual_(mechanism.rows),
      dv_(mechanism.nv) {
  levels_[0].permitted = mechanism.position_rows();
  levels_[1].permitted.assign(static_cast<std::size_t>(mechanism.rows), true);
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    Level& level = levels_[i];
    level.independent = i == 0 ? coordinates : speeds;
    for (int k = 0; k < mechanism.nv; ++k) {
      if (std::ranges::find(level.independent, k) == level.independent.end()) level.dependent.push_back(k);
    }
    const auto n = static_cast<Index>(level.dependent.size());
    level.rows.reserve(level.dependent.size());
    level.J_d.resize(n, n);
  }
  are_same_ = levels_[0].permitted == levels_[1].permitted && levels_[0].dependent == levels_[1].dependent;
}

void DependentCoordinates::set_base(const double* q) {
  std::copy_n(q, base_.size(), base_.begin());
  dynamics_.set_position(q);
  read_jacobian();
  is_determined_ = choose_rows(levels_[0]) && (are_same_ || choose_rows(levels_[1]));
  if (!is_determined_) return;
  if (are_same_) levels_[1].rows = levels_[0].rows;
  Level& level = levels_[0];
  factorize(level);
  tangent_.resize(static_cast<Index>(level.rows.size()), static_cast<Index>(level.independent.size()));
  for (Index k = 0; k < tangent_.cols(); ++k) {
    for (Index r = 0; r < tangent_.rows(); ++r)
      tangent_(r, k) = -J_(level.rows[static_cast<std::size_t>(r)], level.independent[static_cast<std::size_t>(k)]);
  }
  tangent_ = level.lu.solve(tangent_).eval();
}

// At the position of `dynamics`.
void DependentCoordinates::read_jacobian() {
  const SparseRows& rows = dynamics_.rows_of_J();
  J_.setZero();
  for (int r = 0; r < mechanism_.rows; ++r) {
    for (int k = 0; k < rows.entries(r); ++k) J_(r, rows.columns(r)[k]) = rows.values(r)[k];
  }
}

// By Gaussian elimination with full pivoting. Returns false if there are too few.
bool DependentCoordinates::choose_rows(Level& level) {
  const auto n = static_cast<Index>(level.dependent.size());
  level.rows.clear();
  if (n == 0) return true;
  MatrixXd columns = MatrixXd::Zero(J_.rows(), n);
  for (Index r = 0; r < J_.rows(); ++r) {
    for (Index k = 0; k < n && level.permitted[static_cast<std::size_t>(r)]; ++k)
      columns(r, k) = J_(r, level.dependent[static_cast<std::size_t>(k)]);
  }
  const Eigen::FullPivLU<MatrixXd> lu(columns);
  const VectorXd pivots = lu.matrixLU().diagonal().cwiseAbs();
  if (pivots.size() < n || !(pivots[n - 1] > least_pivot_ratio * pivots[0])) {
    find_blocked(level);
    return false;
  }
  for (int r = 0; r < J_.rows(); ++r) {
    if (lu.permutationP().indices()[r] < n) level.rows.push_back(r);
  }
  return true;
}

// Where a dependent motion is almost free while the independent coordinates rest, these almost obey an equation among
// themselves.
void DependentCoordinates::find_blocked(const Level& level) {
  blocked_ = -1;
  MatrixXd dependent = MatrixXd::Zero(J_.rows(), static_cast<Index>(level.dependent.size()));
  MatrixXd independent = MatrixXd::Zero(J_.rows(), static_cast<Index>(level.independent.size()));
  for (Index r = 0; r < J_.rows(); ++r) {
    if (!level.permitted[static_cast<std::size_t>(r)]) continue;
    for (std::size_t k = 0; k < level.dependent.size(); ++k)
      dependent(r, static_cast<Index>(k)) = J_(r, level.dependent[k]);
    for (std::size_t k = 0; k < level.independent.size(); ++k)
      independent(r, static_cast<Index>(k)) = J_(r, level.independent[k]);
  }
  if (independent.cols() == 0) return;
  const Eigen::JacobiSVD<MatrixXd> svd(dependent, Eigen::ComputeFullU);
  double largest = 0;
  for (Index i = std::min(dependent.cols(), dependent.rows()) - 1; i < dependent.rows(); ++i) {
    const VectorXd equation = independent.transpose() * svd.matrixU().col(i);
    Index k = 0;
    if (const double size = equation.cwiseAbs().maxCoeff(&k); size > largest) {
      largest = size;
      blocked_ = level.independent[static_cast<std::size_t>(k)];
    }
  }
}

void DependentCoordinates::displace_base(Eigen::Ref<VectorXd> change, double* q) {
  const Level& level = levels_[0];
  std::copy(base_.begin(), base_.end(), q);
  x_.head(tangent_.rows()).setZero();
  for (Index k = 0; k < tangent_.cols(); ++k)
    x_.head(tangent_.rows()) += tangent_.col(k) * change[level.independent[static_cast<std::size_t>(k)]];
  for (Index k = 0; k < tangent_.rows(); ++k) change[level.dependent[static_cast<std::size_t>(k)]] = x_[k];
  dynamics_.displace(q, change.data());
}

// At the position of `dynamics`. Returns false if the matrix is singular.
bool DependentCoordinates::factorize(Level& level) {
  const auto n = static_cast<Index>(level.rows.size());
  if (n == 0) return true;
  const SparseRows& rows = dynamics_.rows_of_J();
  for (Index r = 0; r < n; ++r) {
    x_.setZero();
    rows.scatter(level.rows[static_cast<std::size_t>(r)], x_.data());
    for (Index k = 0; k < n; ++k) level.J_d(r, k) = x_[level.dependent[static_cast<std::size_t>(k)]];
  }
  level.lu.compute(level.J_d);
  const auto pivots = level.lu.matrixLU().diagonal().cwiseAbs();
  return pivots.minCoeff() > least_pivot_ratio * pivots.maxCoeff();
}

void DependentCoordinates::refactor() {
  if (factorize(levels_[0])) return;
  is_lost_ = true;
  read_jacobian();
  find_blocked(levels_[0]);
}

// One more evaluation of the loops costs as much as new factors.
double DependentCoordinates::renewal_ratio() const { return 1e-4; }

void DependentCoordinates::min_norm_displacement(const double* residual, double* dv) {
  solve(levels_[0], residual, dv);
}

void DependentCoordinates::solve(const Level& level, const double* residual, double* dv) {
  std::fill_n(dv, mechanism_.nv, 0.0);
  const auto n = static_cast<Index>(level.rows.size());
  if (n == 0) return;
  auto x = x_.head(n);  // lu.solve() would allocate memory
  for (Index k = 0; k < n; ++k)
    x[level.lu.permutationP().indices()[k]] = residual[level.rows[static_cast<std::size_t>(k)]];
  level.lu.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(x);
  level.lu.matrixLU().triangularView<Eigen::Upper>().solveInPlace(x);
  for (Index k = 0; k < n; ++k) dv[level.dependent[static_cast<std::size_t>(k)]] = -x[k];
}

bool DependentCoordinates::close(double* y) {
  if (!is_determined_) return false;
  blocked_ = -1;
  is_lost_ = false;
  discard_factors();
  if (close_position(y) && !is_lost_ && close_speeds(y + mechanism_.nq)) return true;
  if (blocked_ < 0) {  // beyond a position that the base is near
    dynamics_.set_position(base_.data());
    read_jacobian();
    find_blocked(levels_[0]);
  }
  return false;
}

// They are linear in the velocities: the second correction removes rounding.
bool DependentCoordinates::close_speeds(double* v) {
  Level& level = levels_[1];
  if (level.rows.empty()) return true;
  if (!factorize(level)) return false;
  const SparseRows& rows = dynamics_.rows_of_J();
  for (int i = 0; i < 2; ++i) {
    if (mechanism_.driven()) {
      dynamics_.set_velocity(v);
      std::copy_n(dynamics_.row_rates().data(), residual_.size(), residual_.data());
    } else {
      for (const int r : level.rows) {
        double sum = 0;
        for (int k = 0; k < rows.entries(r); ++k) sum += rows.values(r)[k] * v[rows.columns(r)[k]];
        residual_[r] = sum;
      }
    }
    solve(level, residual_.data(), dv_.data());
    for (const int k : level.dependent) v[k] += dv_[k];
  }
  return true;
}

}  // namespace gelenk
