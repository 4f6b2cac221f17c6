// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/singular_start.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "assembly/assembly_problem.h"
#include "assembly/loop_closure.h"
#include "linear/descent.h"
#include "linear/weak_rows.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this share the condition on the velocities, which errs by the share, knows them better than J v = b, which errs
// by 2e-16 / share^2.
constexpr double singular_fraction = 5e-6;
constexpr double weak = 2e-5;       // of the largest singular value of J, likewise
constexpr double left_open = 1e-7;  // rad or m: of the position, by rounding of the closed loop
constexpr double met = 1e-10;       // |l^T gamma| over length |v|^2
constexpr int most_searches = 12;   // from velocities at random

// l^T gamma(v) over the velocities that J v = b and the fixed ones leave: v = v0 + W a.
class BranchSearch {
 public:
  BranchSearch(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem, const std::vector<double>& q,
               const std::vector<double>& v)
      : mechanism_(mechanism), dynamics_(dynamics) {
    const AssemblyProblem::Speeds s = problem.speeds(q);
    const std::vector<int>& free = problem.free(AssemblyProblem::Level::velocity);
    const MatrixXd Z = nullspace(MatrixXd(s.G), static_cast<Index>(free.size()), weak);
    W_ = MatrixXd::Zero(mechanism.nv, Z.cols());
    for (std::size_t k = 0; k < free.size(); ++k) W_.row(free[k]) = Z.row(static_cast<Index>(k));
    T_ = s.T * Z;
    // What J v = b has made of the wishes, by pivots that are near zero, is of no concern.
    v0_ = s.v;
    const VectorXd nearest = nearest_speeds(s, weak);
    for (std::size_t k = 0; k < free.size(); ++k) v0_[free[k]] = nearest[static_cast<Index>(k)];
    l_ = weak_rows(dynamics.J(), weak);
    J_size_ = dynamics.J().lpNorm<Eigen::Infinity>();
    speed_ = 0;
    for (const double x : v) speed_ = std::max(speed_, std::abs(x));
    scale_ = speed_ * speed_ * problem.length();
  }

  bool holds(const VectorXd& a) { return largest(excess(a)) <= met * scale_; }
  Index degrees_of_freedom() const { return W_.cols(); }

  // Newton's method with steps of least length: excess() is quadratic, so its central differences are exact. Steps are
  // neither shortened nor damped: a root that is far away is as good, and a search that strays is given up for another.
  bool search(VectorXd& a) {
    for (int i = 0; i < 60; ++i) {
      const VectorXd F = excess(a);
      if (largest(F) <= met * scale_) return true;
      MatrixXd jacobian(F.size(), a.size());
      for (Index k = 0; k < a.size(); ++k) {
        const VectorXd e = speed_ * VectorXd::Unit(a.size(), k);
        jacobian.col(k) = (excess(a + e) - excess(a - e)) / (2 * speed_);
      }
      const VectorXd step = jacobian.completeOrthogonalDecomposition().solve(F);
      if (!step.allFinite() || largest(step) > 1e3 * speed_) return false;
      a -= step;
    }
    return false;
  }

  // The nearest to v0 of those found from several velocities; false: none.
  bool nearest(VectorXd& found) {
    if (degrees_of_freedom() == 0) return holds(found);
    std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same start
    std::normal_distribution<double> normal;
    double least = INFINITY;
    for (int i = 0; i < most_searches; ++i) {
      VectorXd a = VectorXd::Zero(degrees_of_freedom());
      if (i > 0) {
        for (double& x : a) x = 2 * speed_ * normal(random);
      }
      if (!search(a)) continue;
      const double distance = ((T_ * a).squaredNorm() + 1e-6 * a.squaredNorm()) / (speed_ * speed_) + position(a);
      if (distance >= 0.999 * least) continue;
      least = distance;
      found = a;
    }
    return std::isfinite(least);
  }

  // What the position says of the branch: beside a singular configuration J v = b holds on the one the start is on, to
  // what rounding leaves of the position.
  double position(const VectorXd& a) {
    dynamics_.set_velocity(velocity(a).data());
    const std::vector<double>& rates = dynamics_.row_rates();
    const Eigen::Map<const VectorXd> left(rates.data(), static_cast<Index>(rates.size()));
    return (left / (left_open * speed_ * J_size_)).squaredNorm();
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

// The row that has most to do with the smallest of J's singular values that is not zero everywhere.
int weakest_row(const MatrixXd& J, int rank) {
  const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeFullU);
  Index row = 0;
  svd.matrixU().col(rank - 1).cwiseAbs().maxCoeff(&row);
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
  out.share =
      full && mobility.best_pivot_ratio > 0 ? dynamics.pivot_ratio() / mobility.best_pivot_ratio : (full ? 1 : 0);
  if (out.share > doubtful_fraction) return out;
  out.row = weakest_row(dynamics.J(), mobility.rank);
  if (out.share > singular_fraction || !out.moves) return out;
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  BranchSearch search(mechanism, dynamics, problem, start.q, start.v);
  VectorXd a = VectorXd::Zero(search.degrees_of_freedom());
  out.on_branch = search.nearest(a);
  if (out.on_branch) start.v = search.velocity(a);
  return out;
}

}  // namespace gelenk
