// SPDX-License-Identifier: BSD-3-Clause
#include "touch/contact_impact.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "element/contacts/contact.h"
#include "kinematics/loads.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Errors of velocities relative to the largest: of a solution of the cone problem, and up to which one is accepted.
constexpr double impact_cone_tolerance = 1e-13;
constexpr double velocity_tolerance = 1e-8;
constexpr int impact_cone_iterations = 500;
// The energy that an impact may gain by rounding, relative to what it exchanges.
constexpr double energy_rounding = 1e-12;
constexpr int most_bisections = 40;
// Pivots below this fraction of the largest are redundant impulses.
constexpr double redundant_pivot = 1e-9;
// What redundant contacts yield relative to how the bodies do: as little as leaves their impulses well determined,
// since the velocities are solved for to rounding; and the iterations that remove it, of which each gains three digits.
constexpr double yielding_fraction = 1e-4;
// Where a heavy body strikes a light one, what redundant contacts yield is more than how the heavy one does: it is
// reduced by this factor in each iteration, down to this part, where the rounding of the impulses would decide.
constexpr double yielding_reduction = 0.1;
constexpr double least_yielding = 1e-6;
constexpr int most_proximal_iterations = 20;

}  // namespace

Cone cone_of(const TouchEquations::Entry& entry, const std::array<double, contact_groups>& coefficients) {
  Cone cone;
  cone.first = entry.first;
  cone.tangential = entry.rows[0] < 0 ? 0 : 2;
  cone.spin = entry.rows[1] < 0 ? 0 : 1;
  cone.roll = entry.rows[2] < 0 ? 0 : 2;
  cone.friction = coefficients[0];
  cone.spinning = coefficients[1];
  cone.rolling = coefficients[2];
  return cone;
}

ContactImpact::ContactImpact(TouchEquations& touch, const std::vector<int>& spots,
                             const std::vector<StruckLimit>& limits, const double* v, double slow) {
  touch.build(spots, touch.modes(), false, rows_);
  const auto n = static_cast<Index>(spots.size() + limits.size());
  for (const TouchEquations::Entry& entry : rows_.entries) add_contact(touch, entry, slow);
  add_limits(limits);
  touch.respond(rows_.R, Z_);
  G_ = rows_.R * Z_;
  G_ = Eigen::MatrixXd((G_ + G_.transpose()) / 2);
  speeds_ = rows_.R * Eigen::Map<const VectorXd>(v, rows_.R.cols()) + rows_.demanded;
  find_weights();
  x_.setZero(speeds_.size());
  approach_.setZero(n);
  restitution_.setZero(n);
  for (Index i = 0; i < n; ++i) {
    approach_[i] = sign_[i] * speeds_[cones_[static_cast<std::size_t>(i)].first];
    if (!(approach_[i] < -slow)) continue;
    const auto at = static_cast<std::size_t>(i);
    restitution_[i] = at < spots.size() ? touch.law(spots[at]).restitution : limits[at - spots.size()].is.restitution;
  }
}

void ContactImpact::add_contact(const TouchEquations& touch, const TouchEquations::Entry& entry, double slow) {
  std::array<double, contact_groups> coefficients{};
  for (int g = 0; g < contact_groups; ++g) {
    const bool slips = entry.slip[static_cast<std::size_t>(g)].norm() > slow;
    coefficients[static_cast<std::size_t>(g)] = touch.coefficient(entry.spot, g, slips);
  }
  cones_.push_back(cone_of(entry, coefficients));
  poisson_.push_back(0);
}

void ContactImpact::add_limits(const std::vector<StruckLimit>& limits) {
  const Index contacts = rows_.R.rows();
  const auto all = contacts + static_cast<Index>(limits.size());
  sign_.setOnes(static_cast<Index>(cones_.size() + limits.size()));
  if (limits.empty()) return;
  rows_.R.conservativeResize(all, Eigen::NoChange);
  rows_.rates.conservativeResize(all);
  rows_.demanded.conservativeResize(all);
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const Index row = contacts + static_cast<Index>(i);
    const int side = limits[i].is.side;
    const bool held = limits[i].is.held;
    rows_.R.row(row) = limits[i].row;
    rows_.rates[row] = rows_.demanded[row] = 0;
    sign_[static_cast<Index>(cones_.size())] = side > 0 ? -1 : 1;
    cones_.push_back(
        Cone::within(static_cast<int>(row), side > 0 || held ? -unlimited : 0, side < 0 || held ? unlimited : 0));
    poisson_.push_back(limits[i].is.poisson ? 1 : 0);
  }
}

// part: of the restitution. Poisson's impulses are at least (1 + restitution) times those of compression, which others
// may exceed.
bool ContactImpact::solve(ConeSolver& solver, double part) {
  VectorXd b = speeds_;
  VectorXd least = VectorXd::Zero(x_.size());
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const int row = cones_[i].first;
    if (poisson_[i] == 0) {
      b[row] += part * restitution_[at] * sign_[at] * std::min(0.0, approach_[at]);
    } else if (compression_.size() > 0) {
      least[row] = (1 + part * restitution_[at]) * compression_[row];
    }
  }
  b += G_ * least;
  x_ -= least;
  const double residual = weights_.size() == 0 ? solve_cones(solver, G_, b) : solve_redundant(solver, b);
  x_ += least;
  const double fastest = std::max(b.cwiseAbs().maxCoeff(), speeds_.cwiseAbs().maxCoeff());
  return residual <= velocity_tolerance * fastest;
}

// x_ <- impulses in the cones. Returns the error of the velocities.
double ContactImpact::solve_cones(ConeSolver& solver, const Eigen::MatrixXd& matrix, const VectorXd& b) {
  ConeOptions options;
  options.tolerance = impact_cone_tolerance * b.cwiseAbs().maxCoeff();
  options.max_iterations = impact_cone_iterations;
  const DenseConeOperator G(matrix);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  return solver.solve({G, right, cones_, true}, options, x_.data()).residual;
}

// The same where other impulses have the same effect, as at the corners of a box: how they are shared decides on
// friction, and must not depend on rounding. Contacts that yield a little have unique impulses, nearly those of least
// norm; what they yield is removed by proximal iterations (Rockafellar 1976).
double ContactImpact::solve_redundant(ConeSolver& solver, const VectorXd& b) {
  const double enough = impact_cone_tolerance * b.cwiseAbs().maxCoeff();
  x_.setZero();
  double residual = 0;
  double part = 1;
  for (int k = 0; k < most_proximal_iterations; ++k) {
    const VectorXd before = x_;
    const VectorXd weights = part * weights_;
    Eigen::MatrixXd yielding = G_;
    yielding.diagonal() += weights;
    residual = solve_cones(solver, yielding, b - weights.cwiseProduct(before));
    const double yields = weights.cwiseProduct(x_ - before).cwiseAbs().maxCoeff();
    if (yields <= enough) break;
    residual = std::max(residual, yields);
    if (k > 0) part = std::max(least_yielding, yielding_reduction * part);
  }
  return residual;
}

// weights_ <- how much what is struck yields, if impulses are redundant. Equal for what a turn of the axes mixes.
void ContactImpact::find_weights() {
  const VectorXd pivots = G_.ldlt().vectorD().cwiseAbs();
  if (!(pivots.minCoeff() <= redundant_pivot * pivots.maxCoeff())) return;
  weights_.resize(G_.rows());
  const double least = redundant_pivot * G_.diagonal().maxCoeff();
  const auto set = [&](Index first, Index size) {
    if (size > 0) weights_.segment(first, size).setConstant(std::max(G_.diagonal().segment(first, size).mean(), least));
  };
  for (const Cone& cone : cones_) {
    const Index forces = 1 + cone.tangential;
    set(cone.first, forces);
    set(cone.first + forces, cone.spin);
    set(cone.first + forces + cone.spin, cone.roll);
  }
  weights_ *= yielding_fraction;
}

// That the impulses add.
double ContactImpact::energy() const {
  const double before = x_.dot(speeds_);
  const double change = x_.dot(G_ * x_) / 2;
  const double added = before + change;
  return added > energy_rounding * (std::abs(before) + change) ? added : 0;
}

// Where Newton's law would add energy, as it may with friction (Kane & Levinson 1985), restitution is reduced.
bool ContactImpact::solve(ConeSolver& solver) {
  x_.setZero();
  if (std::ranges::count(poisson_, 1) > 0 && compression_.size() == 0) {
    if (!solve(solver, 0)) return false;
    compression_ = x_;
  }
  if (!solve(solver, 1)) return false;
  if (energy() <= 0) return true;
  double low = 0;
  double high = 1;
  for (int k = 0; k < most_bisections; ++k) {
    const double middle = (low + high) / 2;
    (solve(solver, middle) && energy() <= 0 ? low : high) = middle;
  }
  return solve(solver, low);
}

VectorXd ContactImpact::rebounds() const {
  const VectorXd after = speeds_ + G_ * x_;
  VectorXd out(approach_.size());
  for (Index i = 0; i < out.size(); ++i) out[i] = sign_[i] * after[cones_[static_cast<std::size_t>(i)].first];
  return out;
}

VectorXd ContactImpact::accelerations(const double* vdot) const {
  const VectorXd all = rows_.R * Eigen::Map<const VectorXd>(vdot, rows_.R.cols()) + rows_.rates;
  VectorXd out(approach_.size());
  for (Index i = 0; i < out.size(); ++i) out[i] = sign_[i] * all[cones_[static_cast<std::size_t>(i)].first];
  return out;
}

void ContactImpact::apply(double* v) const { Eigen::Map<VectorXd>(v, Z_.rows()) += Z_ * x_; }

}  // namespace gelenk
