// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/projection.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

// Newton stops here: relative to the mechanism's size, some tens of roundings.
constexpr double closed = 1e-14;

// Passing a singular position (a change point, a dead centre). Beside it the weak direction's part of vdot is a
// quotient of two numbers that vanish together, and what is left of rounding and of the step's error in it moves the
// mechanism onto another branch; smaller steps only land nearer. So, as shares of the soundest pivot ratio seen:
constexpr double near_share = 0.5;    // below it the accelerations of accepted steps are remembered
constexpr double sound_share = 0.1;   // below it no more: now they are extrapolated ...
constexpr double weak_share = 0.003;  // ... and near and below this they stand in along the weak direction
constexpr double most_magnified = 1e4;
// With these N-four-bars of 1, 2, 10 and 40 windows keep to their branch for 20 s (56 passages) within 3e-7 m at
// tolerances 1e-6 to 1e-10; three times as large or small serve nearly as well.

double largest(const std::vector<double>& x) {
  double max = 0;
  for (const double value : x) {
    if (!(std::abs(value) <= max)) max = std::abs(value);  // also takes a NaN, and keeps it
  }
  return max;
}

// Of an angle over a step, to tell the turn. A rod that passes the axis on its neighbour closely spins fast for a
// moment; the slower of the two ends then tells its turn, which is less than a half.
double mean_speed(const Cut& cut, double before, double after) {
  if (!cut.is_rod()) return (before + after) / 2;
  if (before * after <= 0) return 0;
  return std::abs(before) < std::abs(after) ? before : after;
}

double size_of(const Mechanism& mechanism) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  return length;
}

}  // namespace

Projection::Projection(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& u)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      u_(u),
      nq_(mechanism.nq),
      nv_(mechanism.nv),
      length_(size_of(mechanism)),
      dv_(mechanism.nv),
      cut_q_(mechanism.cut_nq),
      cut_v_(mechanism.cut_nv),
      cut_v_last_(mechanism.cut_nv) {}

void Projection::factorise() {
  dynamics_.factorise();
  factors_ = true;
  soundest_ = std::max(soundest_, dynamics_.pivot_ratio());
  sound_ = !(dynamics_.pivot_ratio() < sound_share * soundest_);
  dynamics_.set_weak_pivots(sound_ || rigorous_ ? 0 : weak_share * soundest_);
}

// How many times the rounding may be left: along weak directions what is left is small by itself, and leads back where
// the rows are sound again.
double Projection::slack() const { return sound_ ? 1e3 : 1e8; }

// The accelerations that those remembered lead to, by a polynomial in time through as many of the latest as do not
// magnify their rounding too much; null: nothing is known.
const double* Projection::expected(double t) {
  if (u_ != u_seen_) remembered_ = 0;
  if (remembered_ == 0) return nullptr;
  double weights[memory];
  int first = 0;
  for (;; ++first) {
    double sum = 0;
    for (int i = first; i < remembered_; ++i) {
      weights[i] = 1;
      for (int j = first; j < remembered_; ++j) {
        if (j != i) weights[i] *= (t - times_[j]) / (times_[i] - times_[j]);
      }
      sum += std::abs(weights[i]);
    }
    if (sum <= most_magnified) break;  // true for one alone
  }
  expected_.assign(nv_, 0);
  for (int i = first; i < remembered_; ++i) {
    for (int k = 0; k < nv_; ++k) expected_[k] += weights[i] * accelerations_[i][k];
  }
  return expected_.data();
}

// Where `dynamics` stands: at the state accepted at t.
void Projection::remember(double t) {
  factorise();
  if (!sound_) return;
  if (u_ != u_seen_) {
    remembered_ = 0;
    u_seen_ = u_;
  }
  if (remembered_ > 0 && t <= times_[remembered_ - 1]) return;
  if (remembered_ == memory) {
    std::rotate(times_, times_ + 1, times_ + memory);
    std::rotate(accelerations_, accelerations_ + 1, accelerations_ + memory);
    --remembered_;
  }
  times_[remembered_] = t;
  accelerations_[remembered_].resize(nv_);
  dynamics_.solve(u_.data(), accelerations_[remembered_].data());
  ++remembered_;
}

bool Projection::rhs(double t, const double* y, double* ydot) {
  const double* v = y + nq_;
  for (int i = 0; i < nq_ + nv_; ++i) {
    if (!std::isfinite(y[i])) return false;
  }
  dynamics_.set_position(y);
  factorise();
  dynamics_.set_velocity(v);
  dynamics_.solve(u_.data(), ydot + nq_, sound_ ? nullptr : expected(t));
  dynamics_.rate(y, v, ydot);
  return std::all_of(ydot, ydot + size(), [](double x) { return std::isfinite(x); });
}

// With r = 0 and c = 0 along the solution, [M J^T; J 0] d(vdot, lambda) = -(dr, dc).
bool Projection::jacobian(double t, const double* y, double* J) {
  ydot_.resize(size());
  if (!rhs(t, y, ydot_.data())) return false;
  dynamics_.differentiate(u_.data(), static_cast<int>(u_.size()), ydot_.data() + nq_, slopes_);
  Eigen::Map<Eigen::MatrixXd> out(J, size(), size());
  out.topLeftCorner(nq_, nq_) = slopes_.qdot_q;
  out.topRightCorner(nq_, nv_) = slopes_.qdot_v;
  out.bottomLeftCorner(nv_, nq_) = -slopes_.r_q;
  out.bottomRightCorner(nv_, nv_) = -slopes_.r_v;
  slopes_.c_q = -slopes_.c_q;
  slopes_.c_v = -slopes_.c_v;
  for (int k = 0; k < size(); ++k) {
    const double* c = k < nq_ ? slopes_.c_q.col(k).data() : slopes_.c_v.col(k - nq_).data();
    dynamics_.solve_linear(out.col(k).data() + nq_, c);
  }
  return out.allFinite();
}

// Rounding of the rows' errors [m or rad]: of lengths, and of angles that have counted many turns.
double Projection::rounding(const double* q) const {
  double largest_q = 0;
  for (int i = 0; i < nq_; ++i) largest_q = std::max(largest_q, std::abs(q[i]));
  return length_ * std::max(closed, 2e-16 * largest_q);
}

bool Projection::project_position(double* q) {
  dynamics_.normalise(q);
  dynamics_.set_position(q);
  if (mechanism_.rows == 0) return true;
  const double floor = rounding(q);
  double before = INFINITY;
  for (int i = 0; i < 30; ++i) {
    const double gap = largest(dynamics_.Phi());
    if (!std::isfinite(gap)) return false;
    if (gap <= floor) return true;
    // No progress: rounding, or the old factors are too far away.
    if (gap > 0.5 * before && gap <= slack() * floor) return true;
    if (!factors_ || gap > 0.1 * before) {
      factorise();
    }
    before = gap;
    dynamics_.correct(dynamics_.Phi().data(), dv_.data());
    dynamics_.displace(q, dv_.data());
    dynamics_.set_position(q);
  }
  return false;
}

bool Projection::project_velocity(double* v) {
  dynamics_.set_velocity(v);
  if (mechanism_.rows == 0) return true;
  double before = INFINITY;
  for (int i = 0; i < 30; ++i) {
    const double gap = largest(dynamics_.row_rates());
    if (!std::isfinite(gap)) return false;
    double speed = 1;
    for (int k = 0; k < nv_; ++k) speed = std::max(speed, std::abs(v[k]));
    if (gap <= closed * length_ * speed) return true;
    if (gap > 0.5 * before && gap <= slack() * closed * length_ * speed) return true;
    if (!factors_ || gap > 0.1 * before) {
      factorise();
    }
    before = gap;
    dynamics_.correct(dynamics_.row_rates().data(), dv_.data());
    for (int k = 0; k < nv_; ++k) v[k] += dv_[k];
    dynamics_.set_velocity(v);
  }
  return false;
}

bool Projection::project(double, double* y) {
  if (project_position(y) && project_velocity(y + nq_)) return true;
  if (sound_) return false;
  // A long step may have left more along a weak direction than may stay.
  rigorous_ = true;
  factorise();
  const bool closed = project_position(y) && project_velocity(y + nq_);
  rigorous_ = false;
  return closed;
}

void Projection::accepted(double t, const double* y) {
  if (mechanism_.cuts.empty()) return;
  count_turns(t, y);
  if (mechanism_.rows > 0 && dynamics_.pivot_ratio() < near_share * soundest_) remember(t);
}

void Projection::count_from(const std::vector<double>& cut_q, double t, const double* y) {
  cut_q_ = cut_q;
  last_time_ = t;
  std::ranges::fill(cut_v_last_, 0.0);
  count_turns(t, y);
}

// Angles of cut joints are known within a turn; the speeds at both ends of the step say which turn it is.
void Projection::count_turns(double t, const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  const double h = t - last_time_;
  for (std::size_t c = 0; c < mechanism_.cuts.size(); ++c) {
    const Cut& cut = mechanism_.cuts[c];
    dynamics_.cut_speeds(static_cast<int>(c), cut_v_.data() + cut.iv);
    double found[max_cut_nq];
    std::copy_n(cut_q_.data() + cut.iq, cut.nq, found);
    dynamics_.cut_coordinates(static_cast<int>(c), found);
    for (int i = 0; i < cut.nq; ++i) {
      double& q = cut_q_[cut.iq + i];
      if (cut.turns[i]) {
        const double expected = q + h * mean_speed(cut, cut_v_last_[cut.iv + i], cut_v_[cut.iv + i]);
        found[i] += 2 * M_PI * std::round((expected - found[i]) / (2 * M_PI));
      }
      q = found[i];
    }
  }
  cut_v_last_ = cut_v_;
  last_time_ = t;
  dynamics_.set_cut_reference(cut_q_.data());
}

}  // namespace gelenk
