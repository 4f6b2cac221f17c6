// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/frame_adjustment.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "assembly/loop_positions.h"
#include "assembly/parallel_axes.h"
#include "decomposition/dense.h"
#include "decomposition/singular_values.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Outcome = FrameAdjustment::Outcome;
using Coordinates = std::vector<std::vector<double>>;

// Relative to the mechanism's size: closure errors that are rounding. Loops without larger ones are exact.
constexpr double exact_gap = 1e-13;
constexpr double converged_gap = 2e-15;  // relative to the size: a few roundings per product along a loop
// rad, or relative to the size: a frame that has moved no more counts as unmoved.
constexpr double unmoved_tolerance = 1e-15;
// Singular values of J up to so many tolerances, but at most max_zero_sigma, relative to the largest, may be zeros of
// the exact mechanism: misfits of several frames add up, over lever arms.
constexpr double zero_sigma_per_tolerance = 100;
constexpr double max_zero_sigma = 0.05;
constexpr double gap_per_frame = 2;  // in tolerances: the turn and the shift of a frame may both add to a closure error
constexpr int max_ranks = 6;         // number of ranks tried
// The conditions on a 6R linkage with one degree of freedom are up to 15, one per position; more equations than
// conditions are needed to identify the independent ones.
constexpr Index min_equations = 32;
constexpr std::size_t min_positions = 8;
constexpr std::size_t max_positions = 40;
constexpr std::size_t check_positions = 10;  // number of positions at which the result is checked
constexpr int max_rounds = 3;                // of checks, each with the positions at which the previous one has failed
constexpr int max_steps = 20;
// Relative to the largest singular value of the conditions on d: those below some present misfits are undetermined.
constexpr double zero_sigma_per_misfit = 30;
constexpr double min_condition_sigma = 1e-9;
constexpr int closing_attempts = 9;  // starts from which the loops are closed

// Gauss-Newton steps for the frames of a mechanism and several of its positions at a given rank of J. Full steps
// without regard to the residuals: the positions close roughly and the frames hardly move, and if the steps do not
// converge the rank is not that of the exact mechanism, which damping would hide.
class Fit {
 public:
  Fit(LoopGeometry& loops, Index rank, const std::vector<bool>& held_axes) : loops_(loops), rank_(rank) {
    for (std::size_t i = 0; i < held_axes.size(); ++i) {
      // Turns about x and y would tilt an axis of a parallel group.
      for (int k = held_axes[i] ? 2 : 0; k < 6; ++k) free_.push_back(static_cast<Index>(6 * i) + k);
    }
  }

  // Returns the largest closure error that is left.
  double run(Coordinates& positions) {
    double before = INFINITY;
    for (int i = 0;; ++i) {
      const double gap = linearize(positions);
      if (gap <= converged_gap * loops_.size() || i == max_steps || (i > 4 && gap > 0.5 * before)) return gap;
      before = gap;
      step(positions);
    }
  }

 private:
  struct Linearization {
    LoopGeometry::Equations equations;
    SingularValues J;
  };

  double linearize(const Coordinates& positions) {
    linearizations_.clear();
    double gap = 0;
    for (const std::vector<double>& q : positions) {
      LoopGeometry::Equations equations = loops_.equations(q);
      gap = std::max(gap, largest(equations.Phi));
      SingularValues J(equations.J);
      linearizations_.push_back({std::move(equations), std::move(J)});
    }
    return gap;
  }

  // The minimum-norm change of the frames that closes all positions to first order.
  VectorXd change() const {
    const Index each = loops_.rows() - rank_;
    MatrixXd C(each * static_cast<Index>(linearizations_.size()), static_cast<Index>(free_.size()));
    VectorXd b(C.rows());
    for (std::size_t k = 0; k < linearizations_.size(); ++k) {
      const auto left_null_space = linearizations_[k].J.U.rightCols(each);
      const Index first = each * static_cast<Index>(k);
      C.middleRows(first, each) = left_null_space.transpose() * linearizations_[k].equations.A(Eigen::all, free_);
      b.segment(first, each) = left_null_space.transpose() * linearizations_[k].equations.Phi;
    }
    const VectorXd found = least_norm_solution(C, b, std::max(min_condition_sigma, zero_sigma_per_misfit * largest(b)));
    VectorXd d = VectorXd::Zero(static_cast<Index>(6 * loops_.frames().size()));
    for (Index k = 0; k < found.size(); ++k) d[free_[static_cast<std::size_t>(k)]] = -found[k];
    return d;
  }

  void step(Coordinates& positions) {
    const VectorXd d = change();
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const Linearization& at = linearizations_[k];
      positions[k] = loops_.displaced(positions[k], -at.J.solve(at.equations.Phi + at.equations.A * d, rank_));
    }
    loops_.move(d);
  }

  LoopGeometry& loops_;
  Index rank_;
  std::vector<Index> free_;  // indices of the free components of d
  std::vector<Linearization> linearizations_;
};

class Adjuster {
 public:
  Adjuster(const Mechanism& mechanism, double tolerance)
      : mechanism_(mechanism),
        given_(mechanism),
        tolerance_(tolerance),
        misfit_(gap_per_frame * tolerance * static_cast<double>(given_.frames().size()) * given_.size()) {}

  FrameAdjustment run(const std::vector<double>& q) {
    if (given_.rows() == 0 || given_.velocities() == 0) return {};
    const Index full = std::min(given_.rows(), given_.velocities());
    LoopPositions::Position start = closed_from(q, full);
    const double zero = std::min(max_zero_sigma, zero_sigma_per_tolerance * tolerance_) * start.sigma[0];
    Index rank = (start.sigma.array() > zero).count();
    FrameAdjustment best{.outcome = Outcome::none, .moves = {}, .gap = start.gap};
    // Higher mobility first: a motion over a good part of its range is no accident.
    for (int i = 0; i < max_ranks && rank <= full; ++i, ++rank) {
      if (rank == given_.rows()) {  // no constraint is redundant
        FrameAdjustment out;
        out.degrees_of_freedom = static_cast<int>(given_.velocities() - rank);
        return out;
      }
      for (const bool parallel : {true, false}) {
        FrameAdjustment found = adjust(start, rank, parallel);
        if (found.outcome == Outcome::as_given || found.outcome == Outcome::adjusted) return found;
        if (found.outcome == Outcome::too_far && best.outcome == Outcome::none) best = std::move(found);
      }
      // With less mobility the loops would close with smaller changes but could not move.
      if (best.outcome == Outcome::too_far) break;
    }
    return best;
  }

 private:
  LoopPositions::Position closed_from(const std::vector<double>& q, Index rank) const {
    const LoopPositions positions(given_, rank, misfit_);
    std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene is adjusted the same way
    LoopPositions::Position best{.q = {}, .gap = INFINITY, .sigma = {}};
    for (int i = 0; i < closing_attempts && !(best.gap <= misfit_); ++i) {
      std::uniform_real_distribution<double> distribution(-0.4 * i, 0.4 * i);
      VectorXd perturbation(given_.velocities());
      for (double& x : perturbation) x = distribution(random);
      LoopPositions::Position found = positions.closed(i == 0 ? q : given_.displaced(q, perturbation));
      if (best.q.empty() || found.gap < best.gap) best = std::move(found);
    }
    return best;
  }

  std::size_t position_count(Index rank) const {
    if (rank == given_.velocities()) return 1;
    const Index each = given_.rows() - rank;
    return std::clamp(static_cast<std::size_t>((min_equations + each - 1) / each), min_positions, max_positions);
  }

  FrameAdjustment adjust(const LoopPositions::Position& start, Index rank, bool parallel) const {
    FrameAdjustment out{.outcome = Outcome::none, .moves = {}, .gap = 0};
    const LoopPositions near(given_, rank, misfit_);
    const LoopPositions::Position first = near.closed(start.q);
    const std::size_t count = position_count(rank);
    Coordinates positions = near.walk(first, count, 1);
    if (positions.size() < std::min(count, min_positions)) return out;
    for (const std::vector<double>& q : positions) out.gap = std::max(out.gap, largest(given_.equations(q).Phi));
    out.degrees_of_freedom = static_cast<int>(given_.velocities() - rank);
    if (out.gap <= exact_gap * given_.size()) {
      out.outcome = Outcome::as_given;
      return out;
    }
    LoopGeometry loops(mechanism_);
    const std::vector<bool> held = parallel ? make_parallel(loops, tolerance_)  //
                                            : std::vector<bool>(loops.frames().size(), false);
    if (!fit(loops, rank, held, positions)) return out;
    out.moves = moves(loops);
    out.outcome = out.max_move() <= tolerance_ ? Outcome::adjusted : Outcome::too_far;
    return out;
  }

  // Whether the fitted loops close over their whole range of motion.
  bool fit(LoopGeometry& loops, Index rank, const std::vector<bool>& held, Coordinates& positions) const {
    Fit fit(loops, rank, held);
    const LoopPositions exactly(loops, rank, exact_gap * loops.size());
    for (unsigned i = 0; i < max_rounds; ++i) {
      if (!(fit.run(positions) <= exact_gap * loops.size())) return false;
      if (rank == loops.velocities()) return true;
      const std::size_t found = exactly.walk(exactly.closed(positions.front()), check_positions, 2 + i).size();
      if (found == check_positions) return true;
      const LoopPositions roughly(loops, rank, misfit_);
      for (auto& q : roughly.walk(roughly.closed(positions.front()), check_positions, 2 + i)) {
        positions.push_back(std::move(q));
      }
    }
    return false;
  }

  std::vector<FrameMove> moves(const LoopGeometry& loops) const {
    std::vector<FrameMove> out;
    for (const LoopGeometry::Frame& frame : loops.frames()) {
      const Pose3 X = frame.X_given.inverse() * frame.X;
      const double turn = rotation_vector(X.R).norm();
      const double shift = X.p.norm();
      if (turn <= unmoved_tolerance && shift <= unmoved_tolerance * loops.size()) continue;
      out.push_back({.scene_joint = frame.scene_joint,
                     .child = frame.child,
                     .X_given = frame.X_given,
                     .X_move = X,
                     .turn = turn,
                     .shift = shift});
    }
    return out;
  }

  const Mechanism& mechanism_;
  const LoopGeometry given_;
  double tolerance_;
  double misfit_;
};

}  // namespace

double FrameAdjustment::max_move() const {
  double out = 0;
  for (const FrameMove& move : moves) out = std::max({out, move.turn, move.shift});
  return out;
}

FrameAdjustment adjust_frames(const Mechanism& mechanism, const std::vector<double>& q, double tolerance) {
  return Adjuster(mechanism, tolerance).run(q);
}

}  // namespace gelenk
