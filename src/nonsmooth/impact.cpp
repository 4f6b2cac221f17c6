// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/impact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "complementarity/parts_of_problem.h"
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
constexpr int most_iterations = 20 * impact_cone_iterations;  // where impulses are redundant
// The energy that an impact may gain by rounding, relative to what it exchanges.
constexpr double energy_rounding = 1e-12;
// Of the part of the restitution that adds no energy.
constexpr int most_bisections = 50;

bool is_box(const Cone& cone) { return cone.interval; }

}  // namespace

Impact::Impact(MatrixXd G, VectorXd speeds, std::vector<Struck> struck)
    : G_(std::move(G)), speeds_(std::move(speeds)), struck_(std::move(struck)) {
  x_.setZero(speeds_.size());
  for (const Struck& at : struck_) cones_.push_back(at.cone);
  are_boxes_ = std::ranges::all_of(cones_, is_box);
  const DenseConeOperator response(G_);
  const std::span<const double> right(speeds_.data(), static_cast<std::size_t>(speeds_.size()));
  are_redundant_ = !are_boxes_ && redundant_.are_in({response, right, cones_, true});
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
  restitution_.set_part(part);
  restitution_.add_demands(b.data());
  if (compression_.size() > 0) restitution_.set_least_impulses(compression_.data(), least.data());
  b += G_ * least;
  x_ -= least;
  const double residual = are_boxes_ ? solve_boxes(b) : solve_cones(solver, b);
  x_ += least;
  const double fastest = std::max(b.cwiseAbs().maxCoeff(), speeds_.cwiseAbs().maxCoeff());
  return residual <= velocity_tolerance * fastest;
}

// x_ <- impulses in the cones. Returns the error of the velocities.
double Impact::solve_cones(ConeSolver& solver, const VectorXd& b) {
  ConeOptions options;
  options.tolerance = impact_cone_tolerance * b.cwiseAbs().maxCoeff();
  options.max_iterations = impact_cone_iterations;
  const DenseConeOperator G(G_);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  const ConeProblem problem{G, right, cones_, true};
  if (are_redundant_) x_.setZero();
  const ConeResult result = are_redundant_ ? redundant_.solve(solver, problem, options, most_iterations, x_.data())
                                           : solver.solve(problem, options, x_.data());
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

bool Impact::adds_energy() const {
  const double before = x_.dot(speeds_);
  const double change = x_.dot(G_ * x_) / 2;
  return before + change > energy_rounding * (std::abs(before) + change);
}

// rows <- those of the struck with these numbers.
Impact Impact::part(std::span<const std::pair<int, int>> numbers, std::vector<Index>& rows) const {
  rows.clear();
  std::vector<Struck> of;
  for (const auto& [part, number] : numbers) {
    of.push_back(struck_[static_cast<std::size_t>(number)]);
    Cone& cone = of.back().cone;
    for (int k = 0; k < cone.size(); ++k) rows.push_back(cone.first + k);
    cone.first = static_cast<int>(rows.size()) - cone.size();
  }
  return {G_(rows, rows), speeds_(rows), std::move(of)};
}

bool Impact::solve(ConeSolver& solver) {
  PartsOfProblem parts;
  const DenseConeOperator G(G_);
  const std::span<const double> right(speeds_.data(), static_cast<std::size_t>(speeds_.size()));
  if (!parts.divide({G, right, cones_, true})) return solve_together(solver);
  bool found = true;
  std::vector<Index> rows;
  each_part_of(parts.by_part(), [&](std::span<const std::pair<int, int>> numbers) {
    Impact of = part(numbers, rows);
    found = of.solve_together(solver) && found;
    x_(rows) = of.x_;
    iterations_ += of.iterations_;
  });
  return found;
}

bool Impact::solve_together(ConeSolver& solver) {
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
