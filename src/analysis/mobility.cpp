// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/mobility.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "assembly/loop_closure.h"
#include "decomposition/dense.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Pivots below this fraction of the largest belong to redundant constraints: at positions some tenths of a radian away
// from a symmetric one, pivots of independent constraints are far above it, those of redundant ones at the rounding of
// the loop closure.
constexpr double redundancy_pivot_ratio = 1e-8;
// Velocities below this fraction of the largest are zero: rounding of the loop closure, as above.
constexpr double zero_velocity_ratio = 1e-8;
constexpr std::size_t min_positions = 4;  // from which properties of all positions are inferred
constexpr double min_size = 1e-3;         // m: scenes are solved in units near their size
// A smallest pivot below this fraction of the largest may be that of a position near a singular one.
constexpr double near_singular_ratio = 1e-2;
constexpr double exploration_step = 0.3;  // rad: from one position to the next
constexpr double probe_step = 1e-3;       // rad: loops curve by some hundredths of it, or more near singular positions
constexpr double max_deviation_fraction = 0.1;  // of a probe step
// Relative to the largest pivot. If constraints are independent by less than this at all positions visited, and not at
// all at some, their independence is an effect of coordinate errors at singular positions, the square root of the
// closure error.
constexpr double barely_independent_ratio = 1e-5;

// Rank of J; entries up to `rounding` count as zero.
int rank_of(const SparseMatrix& J, double rounding) {
  if (J.nonZeros() == 0 || J.coeffs().abs().maxCoeff() <= rounding) return 0;
  return static_cast<int>(column_rank(J.transpose(), redundancy_pivot_ratio));
}

class Explorer {
 public:
  Explorer(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q)
      : mechanism_(mechanism), dynamics_(dynamics), q_(q) {
    double size = 0;
    for (const Link& link : mechanism.links) size += link.X_PJ.p.norm();
    for (const Cut& cut : mechanism.cuts) size += cut.X_AF.p.norm() + cut.X_BM.p.norm();
    // Mechanisms smaller than a meter are displaced by their size. If all joints meet in one point there are only
    // rotations, and the size is 0 or rounding.
    step_ = exploration_step * (size < min_size ? 1.0 : std::min(1.0, size));
    rounding_ = std::max(redundancy_pivot_ratio * size, 1e-14);
  }

  // Rank of the constraint Jacobian at q_, without a limit.
  int rank_here() {
    set_position(q_, mechanism_.rows);
    const SparseMatrix J = dynamics_.sparse_J();
    if (J.nonZeros() == 0 || J.coeffs().abs().maxCoeff() <= rounding_) return 0;
    if (dynamics_.rank() == mechanism_.rows && dynamics_.pivot_ratio() > redundancy_pivot_ratio) return mechanism_.rows;
    return rank_of(J, rounding_);
  }

  // Entries of the constraint Jacobian up to this are rounding.
  double rounding() const { return rounding_; }

  // A random motion that the constraints at the present position leave free, its largest velocity 1; empty if there is
  // none.
  VectorXd free_motion() {
    VectorXd dv(mechanism_.nv);
    for (auto& x : dv) x = normal_(random_);
    const double initial_size = dv.size() == 0 ? 0 : dv.lpNorm<Eigen::Infinity>();
    if (initial_size == 0) return {};
    if (mechanism_.rows > 0) {
      const SparseMatrix J = dynamics_.sparse_J();
      // Twice: the second projection removes the rounding of the first.
      for (int i = 0; i < 2; ++i) {
        const VectorXd rate = J * dv;
        VectorXd back(mechanism_.nv);
        dynamics_.min_norm_displacement(rate.data(), back.data());
        dv += back;
      }
    }
    const double size = dv.lpNorm<Eigen::Infinity>();
    if (size < 1e-9 * initial_size) return {};
    return dv / size;
  }

  // Moves q_ along a random free motion. Returns false if nothing can move or no closed position was found there.
  bool move(int rank) {
    set_position(q_, rank);
    const VectorXd motion = free_motion();
    return motion.size() > 0 && move_along(motion);
  }

  // Moves q_ along a motion with largest velocity 1.
  bool move_along(const VectorXd& motion) {
    double step = step_;
    for (int attempt = 0; attempt < 3; ++attempt, step /= 3) {
      std::vector<double> moved = q_;
      const VectorXd dv = step * motion;
      dynamics_.displace(moved.data(), dv.data());
      if (!close_rows(mechanism_, dynamics_, moved) || distance(moved) < step / 5) continue;
      previous_q_ = std::move(q_);
      q_ = std::move(moved);
      return true;
    }
    return false;
  }

  // Whether motions that the constraints leave free lead to no closed position, here and at other positions: loops that
  // are rigid at second order, for instance stretched bars whose ends are immobile on the branch explored.
  bool is_rigid_at_second_order(int rank) {
    if (rank == mechanism_.rows) return false;
    for (int i = 0; i < 3; ++i) {
      if (i > 0 && !move(rank)) continue;
      if (can_continue(rank) && can_continue(rank)) return false;
    }
    return true;
  }

  // Returns to the position before the last move.
  void undo_move() { q_ = previous_q_; }

  const std::vector<double>& position() const { return q_; }

  void set_position(const std::vector<double>& q, int limit) {
    dynamics_.set_max_rank(limit);
    dynamics_.set_position(q.data());
    dynamics_.factorize();
  }

 private:
  double distance(const std::vector<double>& q) const { return distance(q, q_); }

  static double distance(const std::vector<double>& a, const std::vector<double>& b) {
    double max = 0;
    for (std::size_t i = 0; i < a.size(); ++i) max = std::max(max, std::abs(a[i] - b[i]));
    return max;
  }

  // Whether the loops close near a small random displacement along a free motion.
  bool can_continue(int rank) {
    set_position(q_, rank);
    const VectorXd motion = free_motion();
    if (motion.size() == 0) return true;
    std::vector<double> ahead = q_;
    const VectorXd dv = probe_step * motion;
    dynamics_.displace(ahead.data(), dv.data());
    std::vector<double> there = ahead;
    return close_rows(mechanism_, dynamics_, there) && distance(there, ahead) < max_deviation_fraction * probe_step;
  }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> q_, previous_q_;
  double step_;
  double rounding_;         // rad/rad or m/rad, as entries of the constraint Jacobian
  std::mt19937 random_{1};  // NOLINT(bugprone-random-generator-seed): the same scene gives the same structure
  std::normal_distribution<double> normal_;
};

// Joints that have not moved in any of the free motions found. At one position a joint's velocity may vanish though it
// moves everywhere else (at a dead center of its loop), so one position alone proves nothing.
class ImmobileJointDetector {
 public:
  ImmobileJointDetector(const Mechanism& mechanism, MobilityAnalysis& out) : mechanism_(mechanism), out_(out) {
    for (const Link& link : mechanism.links) out.immobile_links.push_back(link.nv > 0);
    for (const Cut& cut : mechanism.cuts) out.immobile_cuts.push_back(cut.nv > 0);
  }

  bool any() const {
    const auto any_set = [](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
    return any_set(out_.immobile_links) || any_set(out_.immobile_cuts);
  }

  // Marks no joint as immobile: too few positions are known.
  void clear() {
    out_.immobile_links.assign(out_.immobile_links.size(), false);
    out_.immobile_cuts.assign(out_.immobile_cuts.size(), false);
  }

  // motion: a free motion at the present position of `dynamics`; empty: nothing moves.
  void observe(Dynamics& dynamics, const VectorXd& motion) {
    if (motion.size() == 0) return;
    for (std::size_t i = 0; i < mechanism_.links.size(); ++i) {
      const Link& link = mechanism_.links[i];
      if (link.nv > 0 && motion.segment(link.iv, link.nv).lpNorm<Eigen::Infinity>() > zero_velocity_ratio) {
        out_.immobile_links[i] = false;
      }
    }
    dynamics.set_velocity(motion.data());
    double v[6];
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
      const int nv = mechanism_.cuts[c].nv;
      dynamics.readings().cut_speeds(c, v);
      if (std::any_of(v, v + nv, [](double x) { return std::abs(x) > zero_velocity_ratio; }))
        out_.immobile_cuts[c] = false;
    }
  }

 private:
  const Mechanism& mechanism_;
  MobilityAnalysis& out_;
};

VectorXd unit(const std::vector<double>& motion) {
  const VectorXd v = Eigen::Map<const VectorXd>(motion.data(), static_cast<Index>(motion.size()));
  return v / v.lpNorm<Eigen::Infinity>();
}

// Whether each row is needed, given the constraint Jacobians of several positions side by side: the others are constant
// linear combinations of the needed ones.
std::vector<bool> needed_rows(const MatrixXd& side_by_side, double rounding) {
  const Index rows = side_by_side.rows();
  std::vector<bool> needed(rows, false);
  if (side_by_side.size() == 0) return needed;
  // Zero rows are removed first: an inexpensive test that finds max of them.
  const double least = std::max(rounding, redundancy_pivot_ratio * side_by_side.lpNorm<Eigen::Infinity>());
  std::vector<Index> candidates;
  for (Index r = 0; r < rows; ++r) {
    if (side_by_side.row(r).lpNorm<Eigen::Infinity>() > least) candidates.push_back(r);
  }
  if (candidates.empty()) return needed;
  const MatrixXd columns = side_by_side(candidates, Eigen::all).transpose();
  for (const Index k : independent_columns(columns, redundancy_pivot_ratio)) needed[candidates[k]] = true;
  return needed;
}

// The columns of the result span the multipliers l with J^T l = 0.
MatrixXd left_null_space(const MatrixXd& J, double rounding) {
  if (J.cols() == 0 || J.lpNorm<Eigen::Infinity>() <= rounding) return MatrixXd::Identity(J.rows(), J.rows());
  return null_space(J.transpose(), redundancy_pivot_ratio);
}

// Rank of the constraint equations that hold positions, over all positions visited.
int position_rank_of(const Mechanism& mechanism, const std::vector<SparseMatrix>& jacobians, int rank,
                     double rounding) {
  const std::vector<bool> holds = mechanism.position_rows();
  if (std::ranges::find(holds, false) == holds.end()) return rank;
  int out = 0;
  for (const SparseMatrix& J : jacobians) out = std::max(out, rank_of(position_rows(mechanism, J), rounding));
  return out;
}

// The same for the Jacobians of the positions visited.
std::vector<bool> needed_rows(const Mechanism& mechanism, const std::vector<SparseMatrix>& jacobians, int rank,
                              double rounding) {
  MatrixXd side_by_side(mechanism.rows, mechanism.nv * static_cast<Index>(jacobians.size()));
  for (std::size_t i = 0; i < jacobians.size(); ++i) {
    side_by_side.middleCols(static_cast<Index>(i) * mechanism.nv, mechanism.nv) = jacobians[i];
  }
  std::vector<bool> needed = needed_rows(side_by_side, rounding);
  // Contacts keep all constraint equations: several wheels share their load.
  for (const Cut& cut : mechanism.cuts) {
    if (cut.is_contact()) std::fill_n(needed.begin() + cut.first_row, cut.rows, true);
  }
  // If all positions are too near a singular one, they show too little.
  if (std::ranges::count(needed, true) < rank) needed.assign(mechanism.rows, true);
  return needed;
}

// Lists the needed constraint equations by cut; coordinate rows are all kept.
void list_needed(const Mechanism& mechanism, const std::vector<bool>& needed, MobilityAnalysis& out) {
  for (const Cut& cut : mechanism.cuts) {
    std::vector<int>& kept = out.needed.emplace_back();
    for (int i = 0; i < cut.rows; ++i) {
      if (needed[cut.first_row + i]) kept.push_back(cut.kept[i]);
    }
    out.needed_rows += static_cast<int>(kept.size());
  }
  out.needed_rows += static_cast<int>(mechanism.coordinate_rows.size());
}

// The positions visited.
struct Exploration {
  std::vector<SparseMatrix> rows;  // J at each position of the highest rank
  bool rank_drops = false;         // the rank was lower at some position
};

// Continues from the start position until `positions` positions have been visited, if possible.
void explore(Explorer& explorer, Dynamics& dynamics, const std::vector<double>& initial_direction,
             std::size_t positions, ImmobileJointDetector& immobile, Exploration& exploration, MobilityAnalysis& out) {
  for (std::size_t i = 0; i < 2 * positions && exploration.rows.size() <= positions; ++i) {
    // The initial direction first: of the branches that meet at a singular start, the mechanism follows this one.
    const bool moved =
        i == 0 && !initial_direction.empty() ? explorer.move_along(unit(initial_direction)) : explorer.move(out.rank);
    if (!moved) continue;
    const int rank = explorer.rank_here();
    if (rank < out.rank) {
      exploration.rank_drops = true;
      explorer.undo_move();  // the move led to a singular position, where other branches begin
      continue;
    }
    explorer.set_position(explorer.position(), rank);
    out.best_pivot_ratio =
        rank > out.rank ? dynamics.pivot_ratio() : std::max(out.best_pivot_ratio, dynamics.pivot_ratio());
    out.rank = rank;
    out.generic_q = explorer.position();
    exploration.rows.push_back(dynamics.sparse_J());
    immobile.observe(dynamics, explorer.free_motion());
  }
}

}  // namespace

MobilityAnalysis analyze_mobility(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                  const std::vector<double>& initial_direction) {
  MobilityAnalysis out;
  Explorer explorer(mechanism, dynamics, q);
  ImmobileJointDetector immobile(mechanism, out);
  out.rank = out.rank_start = explorer.rank_here();
  explorer.set_position(q, out.rank);
  out.best_pivot_ratio = dynamics.pivot_ratio();
  immobile.observe(dynamics, explorer.free_motion());
  const bool deficient = out.rank < mechanism.rows;
  Exploration exploration{.rows = {dynamics.sparse_J()}};
  if (deficient || ((immobile.any() || out.best_pivot_ratio < near_singular_ratio) && mechanism.rows > 0)) {
    explore(explorer, dynamics, initial_direction, mechanism.rows <= 100 ? 10 : 4, immobile, exploration, out);
  }
  const bool stuck = exploration.rows.size() == 1 && out.rank < mechanism.nv;
  out.stuck = stuck && deficient;
  const bool by_rounding =
      out.best_pivot_ratio < barely_independent_ratio && (stuck || deficient || exploration.rank_drops);
  // No regular position is known.
  if ((stuck && deficient) || by_rounding || explorer.is_rigid_at_second_order(out.rank))
    out.best_pivot_ratio = INFINITY;
  out.position_rank = position_rank_of(mechanism, exploration.rows, out.rank, explorer.rounding());
  std::vector<bool> needed(mechanism.rows, true);
  // Properties of all positions can be inferred only if several were visited, or if there is only one.
  const bool explored = out.rank == mechanism.nv || exploration.rows.size() >= min_positions;
  // At a singular start branches meet, and a joint that is immobile on the explored one may move on another.
  if (!(out.rank_start == mechanism.nv || (explored && out.rank_start == out.rank))) immobile.clear();
  if (out.rank < mechanism.rows) {
    out.null_multipliers = left_null_space(exploration.rows.back(), explorer.rounding());
    if (exploration.rows.size() == 1) out.generic_q = q;
  }
  if (out.rank < mechanism.rows && explored)
    needed = needed_rows(mechanism, exploration.rows, out.rank, explorer.rounding());
  list_needed(mechanism, needed, out);
  explorer.set_position(q, out.rank);
  return out;
}

MobilityAnalysis analyze_driven_mobility(const Mechanism& mechanism, Dynamics& dynamics,
                                         const Mechanism& free_mechanism, Dynamics& free, const std::vector<double>& q,
                                         const std::vector<double>& initial_direction) {
  MobilityAnalysis out = analyze_mobility(free_mechanism, free, q, initial_direction);
  // Driven joints move as prescribed.
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    for (std::size_t i = 0; i < mechanism.links.size(); ++i) {
      const Link& link = mechanism.links[i];
      for (const CoordinateRow::Term& term : row.terms) {
        if (term.v >= link.iv && term.v < link.iv + link.nv) out.immobile_links[i] = false;
      }
    }
  }
  const int drives = mechanism.rows - free_mechanism.rows;
  out.needed_rows += drives;
  out.rank = out.position_rank = 0;
  out.best_pivot_ratio = 0;
  const std::vector<double> generic = out.generic_q.empty() ? q : out.generic_q;
  for (const auto& at : {generic, q}) {  // q last, where dynamics is left
    Explorer explorer(mechanism, dynamics, at);
    const int rank = out.rank_start = explorer.rank_here();
    explorer.set_position(at, rank);
    out.best_pivot_ratio =
        rank > out.rank ? dynamics.pivot_ratio() : std::max(out.best_pivot_ratio, dynamics.pivot_ratio());
    out.rank = std::max(out.rank, rank);
    out.position_rank =
        std::max(out.position_rank, rank_of(position_rows(mechanism, dynamics.sparse_J()), explorer.rounding()));
  }
  if (out.null_multipliers.cols() > 0) {
    out.null_multipliers.conservativeResize(mechanism.rows, Eigen::NoChange);
    out.null_multipliers.bottomRows(drives).setZero();
  }
  dynamics.set_max_rank(out.rank);
  return out;
}

SparseMatrix position_rows(const Mechanism& mechanism, SparseMatrix J) {
  const std::vector<bool> holds = mechanism.position_rows();
  J.prune([&](Index row, Index, double) { return holds[static_cast<std::size_t>(row)]; });
  return J;
}

}  // namespace gelenk
