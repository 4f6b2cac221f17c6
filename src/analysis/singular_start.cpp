// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/singular_start.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "assembly/assembly_problem.h"
#include "assembly/loop_closure.h"
#include "decomposition/dense.h"
#include "decomposition/singular_values.h"
#include "linear/descent.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this fraction, the condition on the velocities, whose error is the fraction, is more accurate than J v = b,
// whose error is 2e-16 / fraction^2.
constexpr double singular_fraction = 5e-6;
constexpr double weak_sigma_ratio = 2e-5;   // relative to the largest singular value of J, for the same reason
constexpr double position_error = 1e-7;     // rad or m: error of the position due to rounding of the loop closure
constexpr double branch_tolerance = 1e-10;  // |l^T gamma| over length |v|^2
constexpr int max_searches = 12;            // the first from the nearest velocity, the others from random ones

// Solves l^T gamma(v) = 0 over the velocities that satisfy J v = b and the fixed values: v = v0 + W a.
class BranchSearch {
 public:
  BranchSearch(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem, const std::vector<double>& q,
               const std::vector<double>& v)
      : mechanism_(mechanism), dynamics_(dynamics) {
    const AssemblyProblem::VelocityEquations s = problem.velocity_equations(q);
    const std::vector<int>& free = problem.free(AssemblyProblem::Level::velocity);
    const MatrixXd Z = null_space(s.G, weak_sigma_ratio);
    W_ = MatrixXd::Zero(mechanism.nv, Z.cols());
    for (std::size_t k = 0; k < free.size(); ++k) W_.row(free[k]) = Z.row(static_cast<Index>(k));
    T_ = s.T * Z;
    // The velocities from J v = b are not used along pivots near zero, where they are meaningless.
    v0_ = s.v;
    const VectorXd nearest = nearest_velocities(s, weak_sigma_ratio);
    for (std::size_t k = 0; k < free.size(); ++k) v0_[free[k]] = nearest[static_cast<Index>(k)];
    l_ = weak_rows(dynamics.J(), weak_sigma_ratio);
    J_size_ = dynamics.J().lpNorm<Eigen::Infinity>();
    speed_ = 0;
    for (const double x : v) speed_ = std::max(speed_, std::abs(x));
    scale_ = speed_ * speed_ * problem.length();
  }

  bool holds(const VectorXd& a) { return largest(excess(a)) <= branch_tolerance * scale_; }
  Index degrees_of_freedom() const { return W_.cols(); }

  // Newton's method with minimum-norm steps: excess() is quadratic, so its central differences are exact. Steps are
  // neither shortened nor damped: a distant root is as good, and a search that diverges is replaced by another.
  bool search(VectorXd& a) {
    for (int i = 0; i < 60; ++i) {
      const VectorXd F = excess(a);
      if (largest(F) <= branch_tolerance * scale_) return true;
      MatrixXd jacobian(F.size(), a.size());
      for (Index k = 0; k < a.size(); ++k) {
        const VectorXd e = speed_ * VectorXd::Unit(a.size(), k);
        jacobian.col(k) = (excess(a + e) - excess(a - e)) / (2 * speed_);
      }
      const VectorXd step = least_norm_solution(jacobian, F);
      if (!step.allFinite() || largest(step) > 1e3 * speed_) return false;
      a -= step;
    }
    return false;
  }

  // Finds the solution nearest to v0 among searches from several velocities; returns false if there is none.
  bool nearest(VectorXd& found) {
    if (degrees_of_freedom() == 0) return holds(found);
    std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same start
    std::normal_distribution<double> normal;
    double least = INFINITY;
    for (int i = 0; i < max_searches; ++i) {
      VectorXd a = VectorXd::Zero(degrees_of_freedom());
      if (i > 0) {
        for (double& x : a) x = 2 * speed_ * normal(random);
      }
      if (!search(a)) continue;
      const double distance =
          ((T_ * a).squaredNorm() + 1e-6 * a.squaredNorm()) / (speed_ * speed_) + position_penalty(a);
      if (distance >= 0.999 * least) continue;
      least = distance;
      found = a;
    }
    return std::isfinite(least);
  }

  // Squared violation of J v = b relative to the effect of rounding in the position: near a singular configuration it
  // is small on the branch on which the start position lies.
  double position_penalty(const VectorXd& a) {
    dynamics_.set_velocity(velocity(a).data());
    const std::vector<double>& rates = dynamics_.row_rates();
    const Eigen::Map<const VectorXd> left(rates.data(), static_cast<Index>(rates.size()));
    return (left / (position_error * speed_ * J_size_)).squaredNorm();
  }

  std::vector<double> velocity(const VectorXd& a) const {
    std::vector<double> v = v0_;
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += W_.row(k).dot(a);
    return v;
  }

 private:
  VectorXd excess(const VectorXd& a) {
    dynamics_.set_velocity(velocity(a).data());
    return l_.transpose() * Eigen::Map<const VectorXd>(dynamics_.gamma().data(), mechanism_.rows);
  }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> v0_;
  MatrixXd W_, T_, l_;
  double speed_ = 0, scale_ = 0, J_size_ = 0;
};

// The constraint equation with the largest component in the left singular vector of the smallest singular value of J
// that is not zero everywhere.
int weakest_row(const MatrixXd& J, int rank) {
  Index row = 0;
  SingularValues(J).U.col(rank - 1).cwiseAbs().maxCoeff(&row);
  return static_cast<int>(row);
}

}  // namespace

SingularStart examine_start(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                            const InitialGuess& tree, const InitialGuess& cuts, Assembled& start) {
  SingularStart out;
  if (mechanism.rows == 0 || mobility.rank == 0) return out;
  out.moves = std::ranges::any_of(start.v, [](double x) { return x != 0; });
  dynamics.set_max_rank(mobility.rank);
  dynamics.set_position(start.q.data());
  dynamics.factorize();
  const bool full = dynamics.rank() == mobility.rank;
  out.pivot_fraction =
      full && mobility.best_pivot_ratio > 0 ? dynamics.pivot_ratio() / mobility.best_pivot_ratio : (full ? 1 : 0);
  if (out.pivot_fraction > doubtful_fraction) return out;
  out.row = weakest_row(dynamics.J(), mobility.rank);
  if (out.pivot_fraction > singular_fraction || !out.moves) return out;
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  BranchSearch search(mechanism, dynamics, problem, start.q, start.v);
  VectorXd a = VectorXd::Zero(search.degrees_of_freedom());
  out.on_branch = search.nearest(a);
  if (out.on_branch) start.v = search.velocity(a);
  return out;
}

}  // namespace gelenk
