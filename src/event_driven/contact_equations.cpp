// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/contact_equations.h"

#include <algorithm>
#include <cmath>

#include "contact_geometry/contact_finder.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Pivots below this fraction of the largest are redundant forces.
constexpr double rank_threshold = 1e-11;
// Weight of redundant moments.
constexpr double least_moment = 1e-3;
// Rounding of gaps, relative to lengths of order 1; and the most repetitions that remove them.
constexpr double gap_rounding = 1e-15;
constexpr int most_corrections = 8;

// Drops the rows along which what is held, or constraint equations, permit no motion: their response is rounding,
// which must not become a divisor.
void drop_blocked(const ContactEquations::RowMatrix& R, const ContactEquations::RowMatrix& Z, MatrixXd& G,
                  VectorXd& right) {
  for (Index i = 0; i < G.rows(); ++i) {
    if (!is_blocked(G(i, i), R.row(i).norm(), Z.col(i).norm())) continue;
    G.row(i).setZero();
    G.col(i).setZero();
    right[i] = 0;
  }
}

// Normal forces that are given move to the right side. given: by row; of those that act already 0.
void take_given_forces(const ContactEquations::Rows& rows, const VectorXd& given, const MatrixXd& G, VectorXd& right) {
  for (const ContactEquations::Entry& entry : rows.entries) {
    if (entry.is_given && entry.moving[0] >= 0) right -= given[entry.first] * G.col(entry.first);
  }
}

// Each has a row of its own, like any other, of which the solution is known.
void set_given_rows(const ContactEquations::Rows& rows, const VectorXd& given, MatrixXd& G, VectorXd& right) {
  for (const ContactEquations::Entry& entry : rows.entries) {
    if (!entry.is_given) continue;
    const double pivot = G.diagonal().maxCoeff();
    G(entry.first, entry.first) = pivot > 0 ? pivot : 1;
    right[entry.first] = G(entry.first, entry.first) * given[entry.first];
  }
}

}  // namespace

ContactEquations::ContactEquations(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<ContactLaw>& laws,
                                   bool located)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      laws_(laws),
      candidates_(mechanism, located),
      modes_(static_cast<std::size_t>(candidates_.count())),
      solved_modes_(modes_.size()),
      vdot_(static_cast<std::size_t>(mechanism.nv)),
      least_norm_(rank_threshold),
      sharing_(rank_threshold),
      closing_gaps_(rank_threshold),
      closing_speeds_(rank_threshold) {}

const ContactLaw& ContactEquations::law(int candidate) const {
  return laws_[static_cast<std::size_t>(candidates_[candidate].contact)];
}

double ContactEquations::coefficient(int candidate, int group, bool moves) const {
  const ContactLaw& of = law(candidate);
  if (group == 0) return moves ? of.sliding_friction : of.static_friction;
  return group == 1 ? of.spinning : of.rolling;
}

void ContactEquations::set_modes(const std::vector<CandidateMode>& modes) {
  if (&modes != &modes_) modes_ = modes;
  keeps_directions_ = false;  // also where derivatives by differences have been given up
  closed_.clear();
  for (int i = 0; i < candidates_.count(); ++i) {
    if (modes_[static_cast<std::size_t>(i)].closed) closed_.push_back(i);
  }
}

void ContactEquations::add_row(const Entry& entry, const Vector3d& d, bool turns, double* out) const {
  const ContactCandidate& candidate = candidates_[entry.candidate];
  dynamics_.switching_forces().contact_rows().row(candidate.core_link, candidate.tip_link, entry.at.p, d, turns, out);
}

// Direction against which friction acts. Within a step that extends beyond a stop, the velocity's component along the
// direction `before` the stop is mirrored, so that the equations are continuous there and what slips across it is still
// slowed down. Along the opposite of the velocity it would be accelerated: stages of implicit methods would have a
// second solution, in which the body veers off instead of stopping.
Vector3d ContactEquations::moving_direction(const Entry& entry, int group,
                                            const std::vector<CandidateMode>& modes) const {
  const auto g = static_cast<std::size_t>(group);
  const Vector3d& before = modes[static_cast<std::size_t>(entry.candidate)].groups[g].direction;
  const Vector3d& slip = entry.slip[g];
  const double speed = slip.norm();
  if (speed <= (keeps_directions_ ? slow_sliding : no_direction_)) return before;
  const double along = slip.dot(before);
  if (along >= 0) return slip / speed;
  if (group == 1) return -slip / speed;  // about the normal
  const Vector3d mirrored = slip - 2 * along * before;
  if (entry.kept(group) == 3) return mirrored / speed;
  return (mirrored - mirrored.dot(entry.at.n) * entry.at.n).normalized();
}

// Numbers the rows and allocates them.
void ContactEquations::number_rows(const std::vector<CandidateMode>& modes, bool by_modes, Rows& out) const {
  int kept = 0;
  int moving = 0;
  for (Entry& entry : out.entries) {
    entry.first = kept++;
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      entry.rows[g] = entry.moving[g] = -1;
      if (!(coefficient(entry.candidate, group, false) > 0)) continue;
      if (by_modes && modes[static_cast<std::size_t>(entry.candidate)].groups[g].moves) {
        entry.moving[g] = moving++;
      } else {
        entry.rows[g] = kept;
        kept += entry.kept(group);
      }
    }
  }
  out.R.resize(kept, mechanism_.nv);
  out.rates.resize(kept);
  out.demanded.setZero(kept);
  out.S.resize(moving, mechanism_.nv);
  out.moving_rates.resize(moving);
  out.D.setZero(moving > 0 ? static_cast<Index>(out.entries.size()) : 0, mechanism_.nv);
}

void ContactEquations::set_group(const std::vector<CandidateMode>& modes, int group, const RelativeMotion& motion,
                                 Entry& entry, Rows& out) {
  const auto g = static_cast<std::size_t>(group);
  const CandidateState& at = entry.at;
  entry.slip[g].setZero();
  entry.along[g].setZero();
  if (entry.rows[g] < 0 && entry.moving[g] < 0) return;
  const bool turns = candidates_[entry.candidate].group_turns(group);
  const bool about_normal = group == 1;
  Vector3d velocity = turns ? motion.V.w : motion.velocity(at.p);
  Vector3d acceleration = turns ? motion.A.w : motion.acceleration(at.p, at.p_dot);
  Vector3d belt = Vector3d::Zero();
  if (!turns && !law(entry.candidate).belt_velocity.isZero(0)) {
    Vector3d rate;
    belt = candidates_.belt(entry.candidate, law(entry.candidate).belt_velocity, rate);
    velocity += belt;
    acceleration += rate - belt.dot(at.n) * at.n_dot;
  }
  const double along_normal = at.n.dot(velocity);
  entry.slip[g] = about_normal ? Vector3d(along_normal * at.n) : Vector3d(velocity - along_normal * at.n);
  if (entry.kept(group) == 3) entry.slip[g] = velocity;
  const auto rate_along = [&](const Vector3d& d) {
    return d.dot(acceleration) + (about_normal ? d.dot(at.n) * at.n_dot.dot(velocity) : 0);
  };
  if (entry.moving[g] >= 0) {
    entry.along[g] = moving_direction(entry, group, modes);
    add_row(entry, entry.along[g], turns, out.S.row(entry.moving[g]).data());
    out.moving_rates[entry.moving[g]] = rate_along(entry.along[g]);
    out.D.row(&entry - out.entries.data()) -= coefficient(entry.candidate, group, true) * out.S.row(entry.moving[g]);
    return;
  }
  for (Index k = 0; k < entry.kept(group); ++k) {
    const Index row = entry.rows[g] + k;
    const Vector3d d = entry.axis(group, k);
    add_row(entry, d, turns, out.R.row(row).data());
    out.rates[row] = rate_along(d);
    out.demanded[row] = d.dot(belt);
  }
}

void ContactEquations::build(std::span<const int> candidates, const std::vector<CandidateMode>& modes, bool by_modes,
                             Rows& out) {
  out.entries.resize(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Entry& entry = out.entries[i];
    entry.candidate = candidates[i];
    entry.tangential = candidates_[candidates[i]].tangential;
    entry.is_given = candidates_[candidates[i]].is_given();
  }
  number_rows(modes, by_modes, out);
  candidates_.read_motion(dynamics_);
  for (Entry& entry : out.entries) {
    entry.at = candidates_.state(entry.candidate);
    entry.axes = contact_axes(entry.at.n);
    const RelativeMotion motion = candidates_.motion(entry.candidate);
    const bool turns = candidates_[entry.candidate].turns();
    if (entry.is_given) {
      out.R.row(entry.first).setZero();
      out.rates[entry.first] = 0;
    } else {
      add_row(entry, entry.at.n, turns, out.R.row(entry.first).data());
      out.rates[entry.first] = motion.normal_acceleration(entry.at, turns);
    }
    for (int group = 0; group < contact_groups; ++group) set_group(modes, group, motion, entry, out);
  }
}

void ContactEquations::respond(const RowMatrix& F, RowMatrix& Z) {
  Z = F.transpose();
  zero_.assign(static_cast<std::size_t>(std::max(1, mechanism_.rows) * F.rows()), 0.0);
  dynamics_.solve_linear_columns(Z.data(), zero_.data(), static_cast<int>(F.rows()));
}

// Of a force in a norm: moments count as the forces with the same effect, and where several contacts can exert those
// forces, moments, which have narrow limits, are hardly used.
double ContactEquations::weight(const Entry& entry, int group) const {
  if (group == 0) return 1;
  const Index n = entry.first;
  const Index r = entry.rows[static_cast<std::size_t>(group)];
  const double of_moments = std::abs(G_(r, r));
  const double of_forces = std::abs(G_(n, n));
  if (!(of_moments > 0 && of_forces > 0)) return 1;  // what joints do not permit to turn
  return (rows_.entries.size() > 1 ? least_moment : 1) * std::sqrt(of_forces / of_moments);
}

double ContactEquations::accelerate(double* vdot, bool again) {
  if (closed_.empty()) return 0;
  if (!again && solved_at_ == dynamics_.solution() && is_in_solved_modes()) {
    candidates_.read_motion(dynamics_);
    std::ranges::copy(vdot_, vdot);
    return 1;
  }
  const VectorXd before = again ? x_ : VectorXd();
  solve_for_forces(vdot, again);
  if (dynamics_.switching_forces().locks() > 0) add_holding_forces(again ? x_ : shared());
  solved_at_ = again ? -1 : dynamics_.solution();
  std::copy_n(vdot, vdot_.size(), vdot_.begin());
  solved_closed_ = closed_;
  for (const int of : closed_) solved_modes_[static_cast<std::size_t>(of)] = modes_[static_cast<std::size_t>(of)];
  if (!again) return 1;
  const double change = x_.cwiseAbs().maxCoeff();
  x_ += before;
  shared_is_current_ = false;
  right_ = G_ * x_;
  const double size = x_.cwiseAbs().maxCoeff();
  return size > 0 ? change / size : 0;
}

bool ContactEquations::is_in_solved_modes() const {
  return solved_closed_ == closed_ && std::ranges::all_of(closed_, [this](int of) {
           return solved_modes_[static_cast<std::size_t>(of)] == modes_[static_cast<std::size_t>(of)];
         });
}

// x_ <- the forces that are missing in vdot, which are added to it; again: without those that are given.
void ContactEquations::solve_for_forces(double* vdot, bool again) {
  build(closed_, modes_, true, rows_);
  B_ = rows_.R;
  if (rows_.any_moves()) {
    for (std::size_t i = 0; i < rows_.entries.size(); ++i)
      B_.row(rows_.entries[i].first) += rows_.D.row(static_cast<Index>(i));
  }
  respond(B_, Z_);
  // Products without blocking: the matrices are small.
  G_ = rows_.R.lazyProduct(Z_);
  Eigen::Map<VectorXd> a(vdot, mechanism_.nv);
  right_ = -rows_.rates;
  right_ -= rows_.R.lazyProduct(a);
  given_.setZero(right_.size());
  for (const Entry& entry : rows_.entries) given_[entry.first] = again ? 0 : given_normal(entry);
  take_given_forces(rows_, given_, G_, right_);
  drop_blocked(rows_.R, Z_, G_, right_);
  set_given_rows(rows_, given_, G_, right_);
  scale_.setOnes(right_.size());
  for (const Entry& entry : rows_.entries) {
    for (int group = 1; group < contact_groups; ++group) {
      const int row = entry.rows[static_cast<std::size_t>(group)];
      if (row >= 0) scale_.segment(row, entry.kept(group)).setConstant(weight(entry, group));
    }
  }
  least_norm_.solve_weighted(G_, right_, scale_, x_);
  shared_is_current_ = false;
  set_given_forces(rows_, given_, x_);
  a += Z_.lazyProduct(x_);
  const bool is_at_rest = rows_.demanded.isZero(0) && std::ranges::all_of(rows_.entries, &Entry::is_at_rest);
  const auto given = std::ranges::count_if(rows_.entries, &Entry::is_given);
  if (is_at_rest && stops_all(least_norm_.rank() - given)) a.setZero();
}

// Whether rows of this rank leave nothing free to move: then what they keep at rest is at rest exactly, where rounding
// would remain.
bool ContactEquations::stops_all(Index rank) const {
  if (mechanism_.driven() || dynamics_.switching_forces().locks() > 0) return false;
  return rank == mechanism_.nv - dynamics_.rank();
}

// What contact forces do to those that keep coordinates of joints at rest, which depend on how redundant ones are
// distributed.
void ContactEquations::add_holding_forces(const VectorXd& x) {
  SwitchingForces& switching_forces = dynamics_.switching_forces();
  force_ = B_.transpose().lazyProduct(x);
  zero_.assign(static_cast<std::size_t>(std::max(1, mechanism_.rows)), 0.0);
  holding_.resize(static_cast<std::size_t>(switching_forces.locks()));
  std::ranges::fill(holding_, 0.0);
  dynamics_.solve_linear(force_.data(), zero_.data(), nullptr, holding_.data());
  switching_forces.holding_forces().add(holding_);
}

// x <- the least multipliers, in the metric of the mass, that change N v by `left`; Z <- the response to N.
void ContactEquations::close(const RowMatrix& N, Closing& of) {
  respond(N, of.Z);
  of.G = N.lazyProduct(of.Z);
  drop_blocked(N, of.Z, of.G, of.left);
  of.solver.solve(of.G, of.left, of.x);
}

bool ContactEquations::close_position(double* q) {
  if (closed_.empty()) return false;
  bool moved = false;
  VectorXd& gaps = closing_gaps_.left;
  gaps.resize(static_cast<Index>(closed_.size()));
  for (int attempt = 0; attempt < most_corrections; ++attempt) {
    dynamics_.set_position(q);
    candidates_.read_position(dynamics_);
    for (std::size_t i = 0; i < closed_.size(); ++i) gaps[static_cast<Index>(i)] = candidates_.gap(closed_[i]);
    if (!(gaps.cwiseAbs().maxCoeff() > gap_rounding) || !gaps.allFinite()) break;
    build(closed_, modes_, true, kept_);
    closing_gaps_.N.resize(gaps.size(), mechanism_.nv);
    for (std::size_t i = 0; i < closed_.size(); ++i)
      closing_gaps_.N.row(static_cast<Index>(i)) = kept_.R.row(kept_.entries[i].first);
    close(closing_gaps_.N, closing_gaps_);
    closing_gaps_.change = closing_gaps_.Z.lazyProduct(closing_gaps_.x);
    closing_gaps_.change = -closing_gaps_.change;
    dynamics_.displace(q, closing_gaps_.change.data());
    moved = true;
    if (gaps.cwiseAbs().maxCoeff() < 1e-9) break;  // the error that remains is its square
  }
  return moved;
}

void ContactEquations::close_velocity(double* v) {
  if (closed_.empty()) return;
  dynamics_.set_velocity(v);
  Eigen::Map<VectorXd> speeds(v, mechanism_.nv);
  const bool any_belt = std::ranges::any_of(closed_, [&](int of) { return !law(of).belt_velocity.isZero(0); });
  if (!any_belt && speeds.isZero(0)) return;
  build(closed_, modes_, true, kept_);
  closing_speeds_.left = kept_.demanded;
  closing_speeds_.left += kept_.R.lazyProduct(speeds);
  if (closing_speeds_.left.isZero(0)) return;
  close(kept_.R, closing_speeds_);
  speeds -= closing_speeds_.Z.lazyProduct(closing_speeds_.x);
  if (stops_all(closing_speeds_.solver.rank()) && kept_.demanded.isZero(0)) speeds.setZero();
}

}  // namespace gelenk
