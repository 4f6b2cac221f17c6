// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/impact.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "linear/box_complementarity.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Errors of velocities relative to the largest: of a solution of the cone problem, and up to which one is accepted.
constexpr double impact_cone_tolerance = 1e-13;
constexpr double velocity_tolerance = 1e-8;
constexpr int impact_cone_iterations = 500;
// The energy that an impact may gain by rounding, relative to what it exchanges.
constexpr double energy_rounding = 1e-12;
// Of the part of the restitution that adds no energy.
constexpr int most_bisections = 50;
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

bool is_box(const Cone& cone) { return cone.interval; }

}  // namespace

Impact::Impact(MatrixXd G, VectorXd speeds, std::vector<Struck> struck)
    : G_(std::move(G)), speeds_(std::move(speeds)), struck_(std::move(struck)) {
  x_.setZero(speeds_.size());
  for (const Struck& at : struck_) cones_.push_back(at.cone);
  are_boxes_ = std::ranges::all_of(cones_, is_box);
  if (!are_boxes_) find_weights();
}

void Impact::hold(std::size_t i) {
  struck_[i].restitution = 0;
  struck_[i].cone = cones_[i] = Cone::within(struck_[i].cone.first, -unlimited, unlimited);
}

bool Impact::is_held(std::size_t i) const {
  return is_box(cones_[i]) && cones_[i].lower == -unlimited && cones_[i].upper == unlimited;
}

// part: of the restitutions. Others may exceed Poisson's impulses.
bool Impact::solve(ConeSolver& solver, double part) {
  VectorXd b = speeds_;
  VectorXd least = VectorXd::Zero(x_.size());
  restitution_.add_demands(part, b.data());
  if (compression_.size() > 0) restitution_.set_least_impulses(part, compression_.data(), least.data());
  b += G_ * least;
  x_ -= least;
  const double residual = are_boxes_             ? solve_boxes(b)
                          : weights_.size() == 0 ? solve_cones(solver, G_, b)
                                                 : solve_redundant(solver, b);
  x_ += least;
  const double fastest = std::max(b.cwiseAbs().maxCoeff(), speeds_.cwiseAbs().maxCoeff());
  return residual <= velocity_tolerance * fastest;
}

// x_ <- impulses in the cones. Returns the error of the velocities.
double Impact::solve_cones(ConeSolver& solver, const MatrixXd& matrix, const VectorXd& b) {
  ConeOptions options;
  options.tolerance = impact_cone_tolerance * b.cwiseAbs().maxCoeff();
  options.max_iterations = impact_cone_iterations;
  const DenseConeOperator G(matrix);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  const ConeResult result = solver.solve({G, right, cones_, true}, options, x_.data());
  iterations_ += result.iterations;
  return result.residual;
}

double Impact::solve_boxes(const VectorXd& b) {
  VectorXd lower(b.size()), upper(b.size());
  for (const Cone& cone : cones_) {
    lower[cone.first] = cone.lower;
    upper[cone.first] = cone.upper;
  }
  const BoxSolution found = solve_in_box(G_, -b, lower, upper);
  x_ = found.x;
  return found.found ? 0 : unlimited;
}

// As solve_cones() where other impulses have the same effect, as at the corners of a box: how they are shared decides
// on friction, and must not depend on rounding. Contacts that yield a little have unique impulses, nearly those of
// least norm; what they yield is removed by proximal iterations (Rockafellar 1976).
double Impact::solve_redundant(ConeSolver& solver, const VectorXd& b) {
  const double enough = impact_cone_tolerance * b.cwiseAbs().maxCoeff();
  x_.setZero();
  double residual = 0;
  double part = 1;
  for (int k = 0; k < most_proximal_iterations; ++k) {
    const VectorXd before = x_;
    const VectorXd weights = part * weights_;
    MatrixXd yielding = G_;
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
void Impact::find_weights() {
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

bool Impact::adds_energy() const {
  const double before = x_.dot(speeds_);
  const double change = x_.dot(G_ * x_) / 2;
  return before + change > energy_rounding * (std::abs(before) + change);
}

bool Impact::solve(ConeSolver& solver) {
  x_.setZero();
  compression_.resize(0);
  restitution_.clear();
  for (std::size_t i = 0; i < struck_.size(); ++i) {
    const Struck& at = struck_[i];
    restitution_.add({.row = static_cast<int>(row(i)),
                      .sign = at.sign,
                      .restitution = at.restitution,
                      .approach = std::max(0.0, -approach(i)),
                      .poisson = at.poisson});
  }
  if (restitution_.needs_compression()) {
    if (!solve(solver, 0)) return false;
    compression_ = x_;
  }
  if (!solve(solver, 1)) {
    solve(solver, 0);
    return false;
  }
  if (!adds_energy()) return true;
  return solve(solver,
               largest_part(most_bisections, [&](double part) { return solve(solver, part) && !adds_energy(); }));
}

}  // namespace gelenk
