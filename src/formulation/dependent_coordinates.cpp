// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/dependent_coordinates.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "decomposition/singular_values.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Smallest pivot over the largest, below which the independent coordinates count as not determining the others: errors
// of closing the loops, 1e-14, would become larger than tolerances.
constexpr double least_pivot_ratio = 1e-6;
// Fraction of its value when the equations were chosen, below which others are.
constexpr double rechoice_fraction = 0.3;
// Of a way so short that Newton's method remains on the branch [rad, natural units of length].
constexpr double largest_correction = 0.3;
// Velocities are linear in each other: each correction with factors of a position nearby adds as many digits again.
constexpr int most_corrections = 10;
constexpr double speed_rounding = 1e-16;

}  // namespace

DependentCoordinates::DependentCoordinates(const Mechanism& mechanism, Dynamics& dynamics,
                                           const std::vector<int>& coordinates, const std::vector<int>& speeds)
    : ConstraintProjector(mechanism, dynamics),
      base_(static_cast<std::size_t>(mechanism.nq)),
      J_(mechanism.rows, mechanism.nv),
      x_(mechanism.nv),
      row_(mechanism.nv),
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
    level.rows.reserve(level.dependent.size());
    level.factors.resize(level.dependent.size() * level.dependent.size());
    level.pivots.resize(level.dependent.size());
  }
  are_same_ = levels_[0].permitted == levels_[1].permitted && levels_[0].dependent == levels_[1].dependent;
  const auto dependent = static_cast<Index>(levels_[0].dependent.size());
  const auto independent = static_cast<Index>(levels_[0].independent.size());
  tangent_.setZero(dependent, independent);
  speeds_.setZero(independent);
  accelerations_.setZero(dependent);
  drift_.setZero(dependent);
}

void DependentCoordinates::set_base(const double* y) {
  std::copy_n(y, base_.size(), base_.begin());
  dynamics_.set_position(y);
  is_determined_ = keep_rows(levels_[0]) && (are_same_ || keep_rows(levels_[1]));
  if (is_determined_) find_course(y);
}

// Chooses others if necessary. Returns false if there are none; the factors of those kept are at the base.
bool DependentCoordinates::keep_rows(Level& level) {
  if (level.rows.size() == level.dependent.size() && factorize(level) >= rechoice_fraction * level.ratio_when_chosen)
    return true;
  read_jacobian();
  if (!choose_rows(level)) return false;
  level.ratio_when_chosen = factorize(level);
  return level.ratio_when_chosen > least_pivot_ratio;
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
  const SingularValues svd(dependent);
  double largest = 0;
  for (Index i = std::min(dependent.cols(), dependent.rows()) - 1; i < dependent.rows(); ++i) {
    const VectorXd equation = independent.transpose() * svd.U.col(i);
    Index k = 0;
    if (const double size = equation.cwiseAbs().maxCoeff(&k); size > largest) {
      largest = size;
      blocked_ = level.independent[static_cast<std::size_t>(k)];
    }
  }
}

// With the factors at the base.
void DependentCoordinates::find_course(const double* y) {
  Level& level = levels_[0];
  const SparseRows& rows = dynamics_.rows_of_J();
  const double* const v = y + mechanism_.nq;
  for (std::size_t r = 0; r < level.rows.size(); ++r) {
    row_.setZero();
    rows.scatter(level.rows[r], row_.data());
    for (std::size_t k = 0; k < level.independent.size(); ++k)
      tangent_(static_cast<Index>(r), static_cast<Index>(k)) = -row_[level.independent[k]];
  }
  for (Index k = 0; k < tangent_.cols(); ++k) level.solve(tangent_.col(k).data());
  for (Index k = 0; k < speeds_.size(); ++k) speeds_[k] = v[level.independent[static_cast<std::size_t>(k)]];
  dynamics_.set_velocity(v);
  for (std::size_t r = 0; r < level.rows.size(); ++r)
    accelerations_[static_cast<Index>(r)] = dynamics_.gamma()[static_cast<std::size_t>(level.rows[r])];
  level.solve(accelerations_.data());
  if (!mechanism_.driven()) return;
  drift_ = -tangent_ * speeds_;
  for (Index k = 0; k < drift_.size(); ++k) drift_[k] += v[level.dependent[static_cast<std::size_t>(k)]];
}

void DependentCoordinates::displace_base(const VectorXd& change, double* q) {
  std::ranges::copy(base_, q);
  dynamics_.displace(q, change.data());
}

void DependentCoordinates::follow(double dt, Eigen::Ref<VectorXd> change) {
  const Level& level = levels_[0];
  double along = 0;  // sums of products with the velocities at the base
  double square = 0;
  auto dependent = x_.head(tangent_.rows());
  dependent.setZero();
  for (Index k = 0; k < tangent_.cols(); ++k) {
    const double displacement = change[level.independent[static_cast<std::size_t>(k)]];
    dependent += tangent_.col(k) * displacement;
    along += displacement * speeds_[k];
    square += speeds_[k] * speeds_[k];
  }
  const double time = mechanism_.driven() ? dt : along / square;
  if (std::isfinite(time)) dependent += time * time / 2 * accelerations_;
  dependent += dt * drift_;
  for (Index k = 0; k < tangent_.rows(); ++k) change[level.dependent[static_cast<std::size_t>(k)]] = dependent[k];
}

// At the position of `dynamics`. Returns the ratio of the smallest pivot to the largest; 1 if there are none.
double DependentCoordinates::factorize(Level& level) {
  const SparseRows& rows = dynamics_.rows_of_J();
  DenseMatrix A = level.matrix();
  if (A.rows() == 0) return 1;
  for (Index r = 0; r < A.rows(); ++r) {
    row_.setZero();
    rows.scatter(level.rows[static_cast<std::size_t>(r)], row_.data());
    for (Index k = 0; k < A.cols(); ++k) A(r, k) = row_[level.dependent[static_cast<std::size_t>(k)]];
  }
  factorize_general(A, level.pivots.data(), std::numeric_limits<double>::min());
  const auto pivots = A.diagonal().cwiseAbs();
  return pivots.minCoeff() / pivots.maxCoeff();
}

void DependentCoordinates::refactor() {
  if (factorize(levels_[0]) > least_pivot_ratio) return;
  is_lost_ = true;
  read_jacobian();
  find_blocked(levels_[0]);
}

// One more evaluation of the loops costs more than new factors.
double DependentCoordinates::renewal_ratio() const { return 1e-4; }

double DependentCoordinates::most_corrected() const { return largest_correction; }

void DependentCoordinates::solve(Level& level, const double* residual, double* dv) {
  std::fill_n(dv, mechanism_.nv, 0.0);
  for (std::size_t k = 0; k < level.rows.size(); ++k) x_[static_cast<Index>(k)] = residual[level.rows[k]];
  level.solve(x_.data());
  for (std::size_t k = 0; k < level.rows.size(); ++k) dv[level.dependent[k]] = -x_[static_cast<Index>(k)];
}

bool DependentCoordinates::close(double* y) {
  if (!is_determined_) return false;
  blocked_ = -1;
  is_lost_ = false;
  discard_factors();
  return close_position(y) && !is_lost_ && close_speeds(y + mechanism_.nq);
}

void DependentCoordinates::find_blocked_at_base() {
  dynamics_.set_position(base_.data());
  read_jacobian();
  find_blocked(levels_[0]);
}

bool DependentCoordinates::close_speeds(double* v) {
  Level& level = levels_[are_same_ ? 0 : 1];
  if (!are_same_) {
    if (!(factorize(level) > least_pivot_ratio)) return false;
  } else if (!has_factors()) {
    refactorize();
  }
  double before = 0;  // the last correction
  for (int i = 0; i < most_corrections && !is_lost_; ++i) {
    find_residual(level, v);
    solve(level, residual_.data(), dv_.data());
    double change = 0;
    double speed = 1;
    for (const int k : level.dependent) {
      v[k] += dv_[k];
      change = std::max(change, std::abs(dv_[k]));
      speed = std::max(speed, std::abs(v[k]));
    }
    if (!std::isfinite(change)) return false;
    if (change * change <= speed_rounding * speed * before) break;  // the next one would be less
    before = change;
  }
  return !is_lost_;
}

// Of the constraint equations of the velocities.
void DependentCoordinates::find_residual(const Level& level, const double* v) {
  if (mechanism_.driven()) {
    dynamics_.set_velocity(v);
    std::copy_n(dynamics_.row_rates().data(), residual_.size(), residual_.data());
    return;
  }
  const SparseRows& rows = dynamics_.rows_of_J();
  for (const int r : level.rows) {
    double sum = 0;
    for (int k = 0; k < rows.entries(r); ++k) sum += rows.values(r)[k] * v[rows.columns(r)[k]];
    residual_[r] = sum;
  }
}

void DependentCoordinates::serialize(Archive& archive) {
  for (Level& level : levels_) {
    int count = static_cast<int>(level.rows.size());
    archive.serialize_in_range(count, 0, static_cast<int>(level.dependent.size()));
    level.rows.resize(static_cast<std::size_t>(count));
    for (int& row : level.rows) archive.serialize_in_range(row, 0, mechanism_.rows - 1);
    archive.serialize(level.ratio_when_chosen);
  }
}

}  // namespace gelenk
