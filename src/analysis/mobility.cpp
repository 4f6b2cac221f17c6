// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/mobility.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "assembly/loop_closure.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Pivots below this fraction of the largest count as repeated rows: at positions moved off a symmetric one by some
// tenths of a radian, rows that are independent have pivots far above, repeated ones at the closure's rounding.
constexpr double same_row = 1e-8;
// Speeds below this fraction of the fastest stand still: rounding of the closure, as above.
constexpr double no_motion = 1e-8;
constexpr std::size_t enough_positions = 4;
constexpr double least_size = 1e-3;  // m: scenes are solved in units near their size
// A smallest pivot below this share of the largest may be that of a position beside a singular one.
constexpr double doubtful = 1e-2;
constexpr double reach = 0.3;   // rad: from one position to the next
constexpr double small = 1e-3;  // rad: loops curve by less than some hundredths of it, but next to singular positions
constexpr double astray = 0.1;  // of a small step
// Of the largest pivot: where rows are nowhere independent by more, and somewhere not at all, they are so by what
// closing leaves of coordinates in singular positions, its root.
constexpr double barely = 1e-5;

// Entries up to `nothing` are rounding.
int rank_of(const SparseMatrix& J, double nothing) {
  if (J.nonZeros() == 0 || J.coeffs().abs().maxCoeff() <= nothing) return 0;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(MatrixXd(J.transpose()));
  qr.setThreshold(same_row);
  return static_cast<int>(qr.rank());
}

class Explorer {
 public:
  Explorer(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q)
      : mechanism_(mechanism), dynamics_(dynamics), q_(q) {
    double size = 0;
    for (const Link& link : mechanism.links) size += link.X_PJ.p.norm();
    for (const Cut& cut : mechanism.cuts) size += cut.X_AF.p.norm() + cut.X_BM.p.norm();
    // Slides of a mechanism smaller than a metre go as far as its size; where all joints meet in one point, turns are
    // all there is, and the size is 0 or rounding.
    step_ = reach * (size < least_size ? 1.0 : std::min(1.0, size));
    nothing_ = std::max(same_row * size, 1e-14);
  }

  // The rows at q_, rank found with no limit.
  int rank_here() {
    stand(q_, mechanism_.rows);
    const SparseMatrix J = dynamics_.sparse_J();
    if (J.nonZeros() == 0 || J.coeffs().abs().maxCoeff() <= nothing_) return 0;
    if (dynamics_.rank() == mechanism_.rows && dynamics_.pivot_ratio() > same_row) return mechanism_.rows;
    return rank_of(J, nothing_);
  }

  // Entries of the rows up to this are rounding.
  double nothing() const { return nothing_; }

  // A random motion that the rows at the present position leave free, its largest speed 1; empty if there is none.
  VectorXd free_motion() {
    VectorXd dv(mechanism_.nv);
    for (auto& x : dv) x = normal_(random_);
    const double wanted = dv.size() == 0 ? 0 : dv.lpNorm<Eigen::Infinity>();
    if (wanted == 0) return {};
    if (mechanism_.rows > 0) {
      const SparseMatrix J = dynamics_.sparse_J();
      // Twice: what the first leaves of the forbidden part is rounding of the whole.
      for (int i = 0; i < 2; ++i) {
        const VectorXd rate = J * dv;
        VectorXd back(mechanism_.nv);
        dynamics_.min_norm_displacement(rate.data(), back.data());
        dv += back;
      }
    }
    const double size = dv.lpNorm<Eigen::Infinity>();
    if (size < 1e-9 * wanted) return {};
    return dv / size;
  }

  // Moves q_ on along a random free motion. False: nothing can move, or no closed position was found there.
  bool move(int rank) {
    stand(q_, rank);
    const VectorXd motion = free_motion();
    return motion.size() > 0 && move_along(motion);
  }

  // motion: its largest speed 1.
  bool move_along(const VectorXd& motion) {
    double step = step_;
    for (int attempt = 0; attempt < 3; ++attempt, step /= 3) {
      std::vector<double> moved = q_;
      const VectorXd dv = step * motion;
      dynamics_.displace(moved.data(), dv.data());
      if (!close_rows(mechanism_, dynamics_, moved) || distance(moved) < step / 5) continue;
      before_ = std::move(q_);
      q_ = std::move(moved);
      return true;
    }
    return false;
  }

  // Whether there are motions that the rows leave free and that lead nowhere, at this position and at others: loops
  // that are rigid at second order, stretched bars for instance whose ends stand still on the branch that is seen.
  bool is_rigid_at_second_order(int rank) {
    if (rank == mechanism_.rows) return false;
    for (int i = 0; i < 3; ++i) {
      if (i > 0 && !move(rank)) continue;
      if (leads_on(rank) && leads_on(rank)) return false;
    }
    return true;
  }

  // To before the last move.
  void back() { q_ = before_; }

  const std::vector<double>& position() const { return q_; }

  void stand(const std::vector<double>& q, int limit) {
    dynamics_.set_max_rank(limit);
    dynamics_.set_position(q.data());
    dynamics_.factorize();
  }

 private:
  double distance(const std::vector<double>& q) const { return distance(q, q_); }

  static double distance(const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
  }

  // Whether the loops close where a small random step along what is free has led.
  bool leads_on(int rank) {
    stand(q_, rank);
    const VectorXd motion = free_motion();
    if (motion.size() == 0) return true;
    std::vector<double> ahead = q_;
    const VectorXd dv = small * motion;
    dynamics_.displace(ahead.data(), dv.data());
    std::vector<double> there = ahead;
    return close_rows(mechanism_, dynamics_, there) && distance(there, ahead) < astray * small;
  }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> q_, before_;
  double step_;
  double nothing_;          // rad/rad or m/rad, as the rows
  std::mt19937 random_{1};  // NOLINT(bugprone-random-generator-seed): the same scene gives the same structure
  std::normal_distribution<double> normal_;
};

// Joints none of whose speeds has moved in any of the free motions seen. At one position a joint's rate may vanish
// though the joint moves everywhere else (a dead centre of its loop), so one position alone proves nothing.
class Standing {
 public:
  Standing(const Mechanism& mechanism, MobilityAnalysis& out) : mechanism_(mechanism), out_(out) {
    for (const Link& link : mechanism.links) out.immobile_links.push_back(link.nv > 0);
    for (const Cut& cut : mechanism.cuts) out.immobile_cuts.push_back(cut.nv > 0);
  }

  bool any() const {
    const auto some = [](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
    return some(out_.immobile_links) || some(out_.immobile_cuts);
  }

  // Too little was seen to tell.
  void none() {
    out_.immobile_links.assign(out_.immobile_links.size(), false);
    out_.immobile_cuts.assign(out_.immobile_cuts.size(), false);
  }

  // motion: at the position at which `dynamics` stands; empty: nothing moves.
  void see(Dynamics& dynamics, const VectorXd& motion) {
    if (motion.size() == 0) return;
    for (std::size_t i = 0; i < mechanism_.links.size(); ++i) {
      const Link& link = mechanism_.links[i];
      if (link.nv > 0 && motion.segment(link.iv, link.nv).lpNorm<Eigen::Infinity>() > no_motion) {
        out_.immobile_links[i] = false;
      }
    }
    dynamics.set_velocity(motion.data());
    double v[6];
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
      const int nv = mechanism_.cuts[c].nv;
      dynamics.readings().cut_speeds(c, v);
      if (std::any_of(v, v + nv, [](double x) { return std::abs(x) > no_motion; })) out_.immobile_cuts[c] = false;
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

// Rows that are constant combinations of the others, given the rows at several positions side by side. Returns
// the others.
std::vector<bool> needed_rows(const MatrixXd& side_by_side, double nothing) {
  const Index rows = side_by_side.rows();
  std::vector<bool> needed(rows, false);
  if (side_by_side.size() == 0) return needed;
  // First those that never do anything: cheap, and most of those there are.
  const double least = std::max(nothing, same_row * side_by_side.lpNorm<Eigen::Infinity>());
  std::vector<Index> candidates;
  for (Index r = 0; r < rows; ++r) {
    if (side_by_side.row(r).lpNorm<Eigen::Infinity>() > least) candidates.push_back(r);
  }
  if (candidates.empty()) return needed;
  const MatrixXd columns = side_by_side(candidates, Eigen::all).transpose();
  Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  qr.setThreshold(same_row);
  for (Index k = 0; k < qr.rank(); ++k) needed[candidates[qr.colsPermutation().indices()[k]]] = true;
  return needed;
}

// Columns span the multipliers l with J^T l = 0.
MatrixXd left_null_space(const MatrixXd& J, double nothing) {
  if (J.cols() == 0 || J.lpNorm<Eigen::Infinity>() <= nothing) return MatrixXd::Identity(J.rows(), J.rows());
  Eigen::ColPivHouseholderQR<MatrixXd> qr(J);
  qr.setThreshold(same_row);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(J.rows(), J.rows());
  return Q.rightCols(J.rows() - qr.rank());
}

// Of the rows that hold positions, where they have been seen.
int position_rank_of(const Mechanism& mechanism, const std::vector<SparseMatrix>& seen, int rank, double nothing) {
  const std::vector<bool> holds = mechanism.position_rows();
  if (std::ranges::find(holds, false) == holds.end()) return rank;
  int out = 0;
  for (const SparseMatrix& J : seen) out = std::max(out, rank_of(position_rows(mechanism, J), nothing));
  return out;
}

// The same, given the rows at each of the positions.
std::vector<bool> needed_rows(const Mechanism& mechanism, const std::vector<SparseMatrix>& seen, int rank,
                              double nothing) {
  MatrixXd side_by_side(mechanism.rows, mechanism.nv * static_cast<Index>(seen.size()));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    side_by_side.middleCols(static_cast<Index>(i) * mechanism.nv, mechanism.nv) = seen[i];
  }
  std::vector<bool> needed = needed_rows(side_by_side, nothing);
  // Of contacts all stay: what several wheels carry, they share.
  for (const Cut& cut : mechanism.cuts) {
    if (cut.is_contact()) std::fill_n(needed.begin() + cut.first_row, cut.rows, true);
  }
  // Positions all too near a singular one tell too little.
  if (std::ranges::count(needed, true) < rank) needed.assign(mechanism.rows, true);
  return needed;
}

// By cut; coordinate rows all stay.
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

// What the positions have shown.
struct Seen {
  std::vector<SparseMatrix> rows;  // J at each position of the highest rank
  bool less_elsewhere = false;     // at some the rank was lower
};

// Goes on from the start, where it has begun, and sees so many positions, if it can.
void explore(Explorer& explorer, Dynamics& dynamics, const std::vector<double>& way, std::size_t positions,
             Standing& standing, Seen& seen, MobilityAnalysis& out) {
  for (std::size_t i = 0; i < 2 * positions && seen.rows.size() <= positions; ++i) {
    // First the way it will go: of the branches that meet in a singular start, this is the one that counts.
    const bool moved = i == 0 && !way.empty() ? explorer.move_along(unit(way)) : explorer.move(out.rank);
    if (!moved) continue;
    const int rank = explorer.rank_here();
    if (rank < out.rank) {
      seen.less_elsewhere = true;
      explorer.back();  // into a singular position, from where other branches lead
      continue;
    }
    explorer.stand(explorer.position(), rank);
    out.best_pivot_ratio =
        rank > out.rank ? dynamics.pivot_ratio() : std::max(out.best_pivot_ratio, dynamics.pivot_ratio());
    out.rank = rank;
    out.generic_q = explorer.position();
    seen.rows.push_back(dynamics.sparse_J());
    standing.see(dynamics, explorer.free_motion());
  }
}

}  // namespace

MobilityAnalysis analyze_mobility(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                  const std::vector<double>& way) {
  MobilityAnalysis out;
  Explorer explorer(mechanism, dynamics, q);
  Standing standing(mechanism, out);
  out.rank = out.rank_start = explorer.rank_here();
  explorer.stand(q, out.rank);
  out.best_pivot_ratio = dynamics.pivot_ratio();
  standing.see(dynamics, explorer.free_motion());
  const bool deficient = out.rank < mechanism.rows;
  Seen seen{.rows = {dynamics.sparse_J()}};
  if (deficient || ((standing.any() || out.best_pivot_ratio < doubtful) && mechanism.rows > 0)) {
    explore(explorer, dynamics, way, mechanism.rows <= 100 ? 10 : 4, standing, seen, out);
  }
  const bool stuck = seen.rows.size() == 1 && out.rank < mechanism.nv;
  out.stuck = stuck && deficient;
  const bool by_rounding = out.best_pivot_ratio < barely && (stuck || deficient || seen.less_elsewhere);
  // No sound position is known.
  if ((stuck && deficient) || by_rounding || explorer.is_rigid_at_second_order(out.rank))
    out.best_pivot_ratio = INFINITY;
  out.position_rank = position_rank_of(mechanism, seen.rows, out.rank, explorer.nothing());
  std::vector<bool> needed(mechanism.rows, true);
  // What holds everywhere can be told only where several positions were seen, or where there is but one.
  const bool explored = out.rank == mechanism.nv || seen.rows.size() >= enough_positions;
  // In a singular start branches meet, and what stands on the one that was explored may move on another.
  if (!(out.rank_start == mechanism.nv || (explored && out.rank_start == out.rank))) standing.none();
  if (out.rank < mechanism.rows) {
    out.null_multipliers = left_null_space(seen.rows.back(), explorer.nothing());
    if (seen.rows.size() == 1) out.generic_q = q;
  }
  if (out.rank < mechanism.rows && explored) needed = needed_rows(mechanism, seen.rows, out.rank, explorer.nothing());
  list_needed(mechanism, needed, out);
  explorer.stand(q, out.rank);
  return out;
}

MobilityAnalysis analyze_driven_mobility(const Mechanism& mechanism, Dynamics& dynamics,
                                         const Mechanism& free_mechanism, Dynamics& free, const std::vector<double>& q,
                                         const std::vector<double>& way) {
  MobilityAnalysis out = analyze_mobility(free_mechanism, free, q, way);
  // Driven joints stand or move as they are told.
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
  const std::vector<double> elsewhere = out.generic_q.empty() ? q : out.generic_q;
  for (const auto& at : {elsewhere, q}) {  // at q last
    Explorer explorer(mechanism, dynamics, at);
    const int rank = out.rank_start = explorer.rank_here();
    explorer.stand(at, rank);
    out.best_pivot_ratio =
        rank > out.rank ? dynamics.pivot_ratio() : std::max(out.best_pivot_ratio, dynamics.pivot_ratio());
    out.rank = std::max(out.rank, rank);
    out.position_rank =
        std::max(out.position_rank, rank_of(position_rows(mechanism, dynamics.sparse_J()), explorer.nothing()));
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
