// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/frame_adjustment.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "assembly/loop_positions.h"
#include "assembly/parallel_axes.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Outcome = FrameAdjustment::Outcome;
using Coordinates = std::vector<std::vector<double>>;

// Of the mechanism's size: gaps that are rounding. Loops with no larger ones are exact.
constexpr double exact = 1e-13;
constexpr double converged = 2e-15;  // likewise, of the steps: a few roundings of each product along a loop
// A frame that has been moved by no more, in rad or of the size, is where it was.
constexpr double nothing = 1e-15;
// Singular values of J up to so many tolerances, or this, may be zeros of the exact mechanism: misfits of some frames
// add up, over levers.
constexpr double singular_per_tolerance = 100;
constexpr double most_singular = 0.05;
constexpr double gap_per_frame = 2;  // in tolerances: each frame may have both its turn and its shift in a gap
constexpr int most_ranks = 6;        // tried one after the other
// The conditions on a 6R linkage with one freedom are up to 15 and one a position; more equations than conditions are
// needed to tell which are independent.
constexpr Index enough_equations = 32;
constexpr std::size_t least_positions = 8;
constexpr std::size_t most_positions = 40;
constexpr std::size_t other_positions = 10;  // where the result is checked
constexpr int rounds = 3;                    // of checks, each with the positions at which the one before has failed
constexpr int most_steps = 20;
// Singular values of the conditions on d, of the largest: below some misfits of the present mechanism they are unknown.
constexpr double unknown_per_misfit = 30;
constexpr double unknown = 1e-9;
constexpr int attempts = 9;  // starts from which to close the loops

// Gauss-Newton steps for the frames of a mechanism and positions of it, J's rank given. Whole ones, none of them judged
// by its residuals: positions that close roughly and frames that hardly move are near enough, and where steps do not
// converge the rank is not that of the exact mechanism, which damping would hide.
class Fit {
 public:
  Fit(LoopGeometry& loops, Index rank, const std::vector<bool>& held_axes) : loops_(loops), rank_(rank) {
    for (std::size_t i = 0; i < held_axes.size(); ++i) {
      // Turns about x and y would tilt an axis of a parallel group.
      for (int k = held_axes[i] ? 2 : 0; k < 6; ++k) free_.push_back(static_cast<Index>(6 * i) + k);
    }
  }

  // Returns the largest gap that is left.
  double run(Coordinates& positions) {
    double before = INFINITY;
    for (int i = 0;; ++i) {
      const double gap = look(positions);
      if (gap <= converged * loops_.size() || i == most_steps || (i > 4 && gap > 0.5 * before)) return gap;
      before = gap;
      step(positions);
    }
  }

 private:
  struct Local {
    LoopGeometry::Equations equations;
    Decomposition J;
  };

  double look(const Coordinates& positions) {
    here_.clear();
    double gap = 0;
    for (const std::vector<double>& q : positions) {
      LoopGeometry::Equations equations = loops_.equations(q);
      gap = std::max(gap, largest(equations.Phi));
      Decomposition J(equations.J);
      here_.push_back({std::move(equations), std::move(J)});
    }
    return gap;
  }

  // The least change of the frames that closes all positions, to first order.
  VectorXd change() const {
    const Index each = loops_.rows() - rank_;
    MatrixXd C(each * static_cast<Index>(here_.size()), static_cast<Index>(free_.size()));
    VectorXd b(C.rows());
    for (std::size_t k = 0; k < here_.size(); ++k) {
      const auto idle = here_[k].J.U.rightCols(each);
      const Index first = each * static_cast<Index>(k);
      C.middleRows(first, each) = idle.transpose() * here_[k].equations.A(Eigen::all, free_);
      b.segment(first, each) = idle.transpose() * here_[k].equations.Phi;
    }
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> conditions(C.rows(), C.cols());
    conditions.setThreshold(std::max(unknown, unknown_per_misfit * largest(b)));
    const VectorXd found = conditions.compute(C).solve(b);
    VectorXd d = VectorXd::Zero(static_cast<Index>(6 * loops_.frames().size()));
    for (Index k = 0; k < found.size(); ++k) d[free_[static_cast<std::size_t>(k)]] = -found[k];
    return d;
  }

  void step(Coordinates& positions) {
    const VectorXd d = change();
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const Local& at = here_[k];
      positions[k] = loops_.displaced(positions[k], -at.J.solve(at.equations.Phi + at.equations.A * d, rank_));
    }
    loops_.move(d);
  }

  LoopGeometry& loops_;
  Index rank_;
  std::vector<Index> free_;  // of d
  std::vector<Local> here_;
};

class Adjuster {
 public:
  Adjuster(const Mechanism& mechanism, double tolerance)
      : mechanism_(mechanism),
        given_(mechanism),
        tolerance_(tolerance),
        misfit_(gap_per_frame * tolerance * static_cast<double>(given_.frames().size()) * given_.size()) {}

  FrameAdjustment run(const std::vector<double>& q) {
    if (given_.rows() == 0 || given_.speeds() == 0) return {};
    const Index full = std::min(given_.rows(), given_.speeds());
    LoopPositions::Position start = closed_from(q, full);
    const double zero = std::min(most_singular, singular_per_tolerance * tolerance_) * start.sigma[0];
    Index rank = (start.sigma.array() > zero).count();
    FrameAdjustment best{.outcome = Outcome::none, .moves = {}, .gap = start.gap};
    // The most mobile mechanism near the one given: a motion over a good part of its range is no accident.
    for (int i = 0; i < most_ranks && rank <= full; ++i, ++rank) {
      if (rank == given_.rows()) {  // nothing is redundant
        FrameAdjustment out;
        out.degrees_of_freedom = static_cast<int>(given_.speeds() - rank);
        return out;
      }
      for (const bool parallel : {true, false}) {
        FrameAdjustment found = adjust(start, rank, parallel);
        if (found.outcome == Outcome::as_given || found.outcome == Outcome::adjusted) return found;
        if (found.outcome == Outcome::too_far && best.outcome == Outcome::none) best = std::move(found);
      }
      // With less mobility it would close with less change, and stand still.
      if (best.outcome == Outcome::too_far) break;
    }
    return best;
  }

 private:
  LoopPositions::Position closed_from(const std::vector<double>& q, Index rank) const {
    const LoopPositions positions(given_, rank, misfit_);
    std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene is adjusted the same way
    LoopPositions::Position best{.q = {}, .gap = INFINITY, .sigma = {}};
    for (int i = 0; i < attempts && !(best.gap <= misfit_); ++i) {
      std::uniform_real_distribution<double> shake(-0.4 * i, 0.4 * i);
      VectorXd beside(given_.speeds());
      for (double& x : beside) x = shake(random);
      LoopPositions::Position found = positions.closed(i == 0 ? q : given_.displaced(q, beside));
      if (best.q.empty() || found.gap < best.gap) best = std::move(found);
    }
    return best;
  }

  std::size_t wanted_positions(Index rank) const {
    if (rank == given_.speeds()) return 1;
    const Index each = given_.rows() - rank;
    return std::clamp(static_cast<std::size_t>((enough_equations + each - 1) / each), least_positions, most_positions);
  }

  FrameAdjustment adjust(const LoopPositions::Position& start, Index rank, bool parallel) const {
    FrameAdjustment out{.outcome = Outcome::none, .moves = {}, .gap = 0};
    const LoopPositions near(given_, rank, misfit_);
    const LoopPositions::Position first = near.closed(start.q);
    const std::size_t wanted = wanted_positions(rank);
    Coordinates positions = near.walk(first, wanted, 1);
    if (positions.size() < std::min(wanted, least_positions)) return out;
    for (const std::vector<double>& q : positions) out.gap = std::max(out.gap, largest(given_.equations(q).Phi));
    out.degrees_of_freedom = static_cast<int>(given_.speeds() - rank);
    if (out.gap <= exact * given_.size()) {
      out.outcome = Outcome::as_given;
      return out;
    }
    LoopGeometry loops(mechanism_);
    const std::vector<bool> held = parallel ? make_parallel(loops, tolerance_)  //
                                            : std::vector<bool>(loops.frames().size(), false);
    if (!fit(loops, rank, held, positions)) return out;
    out.moves = moves(loops);
    out.outcome = out.most() <= tolerance_ ? Outcome::adjusted : Outcome::too_far;
    return out;
  }

  // Whether the loops close everywhere they go.
  bool fit(LoopGeometry& loops, Index rank, const std::vector<bool>& held, Coordinates& positions) const {
    Fit fit(loops, rank, held);
    const LoopPositions exactly(loops, rank, exact * loops.size());
    for (unsigned i = 0; i < rounds; ++i) {
      if (!(fit.run(positions) <= exact * loops.size())) return false;
      if (rank == loops.speeds()) return true;
      const std::size_t found = exactly.walk(exactly.closed(positions.front()), other_positions, 2 + i).size();
      if (found == other_positions) return true;
      const LoopPositions roughly(loops, rank, misfit_);
      for (auto& q : roughly.walk(roughly.closed(positions.front()), other_positions, 2 + i)) {
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
      if (turn <= nothing && shift <= nothing * loops.size()) continue;
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

double FrameAdjustment::most() const {
  double out = 0;
  for (const FrameMove& move : moves) out = std::max({out, move.turn, move.shift});
  return out;
}

FrameAdjustment adjust_frames(const Mechanism& mechanism, const std::vector<double>& q, double tolerance) {
  return Adjuster(mechanism, tolerance).run(q);
}

}  // namespace gelenk
