// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/formulation.h"

#include <algorithm>
#include <cmath>

#include "scene/element_numbers.h"

namespace gelenk {
namespace {

// Newton stops here: relative to the mechanism's size, some tens of roundings.
constexpr double closed = 1e-14;
// Pivots of the rows, the least over the largest, below which such a place is why a step fails.
constexpr double dead = 0.1;
// Share of the mechanism's size [m], or rad for each metre of it, that corrections may move a driven one: beyond it
// lies another assembly, where a motion leads that the loops cannot follow.
constexpr double elsewhere = 0.3;

double largest(const std::vector<double>& x) {
  double max = 0;
  for (const double value : x) {
    if (!(std::abs(value) <= max)) max = std::abs(value);  // also takes a NaN, and keeps it
  }
  return max;
}

// Without a branch for each: zero times anything else is no number.
bool all_finite(const double* x, int n) {
  double none = 0;
  for (int i = 0; i < n; ++i) none += 0 * x[i];
  return none == 0;
}

double size_of(const Mechanism& mechanism) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  return length;
}

}  // namespace

Formulation::Formulation(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      inputs_(u),
      u_(u.now()),
      nq_(mechanism.nq),
      nv_(mechanism.nv),
      targets_(mechanism),
      turns_(mechanism, dynamics),
      length_(size_of(mechanism)),
      dv_(mechanism.nv) {
  sides_.resize(static_cast<std::size_t>(dynamics.branchings()));
  present_.resize(sides_.size());
  for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
    if (can_be_undefined(mechanism.cuts[c].joint)) delicate_.push_back(c);
  }
}

bool Formulation::rows_are_defined() const {
  return std::ranges::none_of(delicate_,
                              [&](int c) { return is_undefined(mechanism_.cuts[c].joint, dynamics_.cut_pose(c)); });
}

// Where dynamics_ stands.
std::string Formulation::dead_centre() {
  if (!mechanism_.driven()) return {};
  renew_factors();
  if (dynamics_.pivot_ratio() > dead) return {};
  return "a loop stands near a dead centre of what drives it, beyond which a given motion cannot be followed";
}

std::string Formulation::obstacle(const double* y) {
  dynamics_.set_position(y);
  for (const int c : delicate_) {
    const Cut& cut = mechanism_.cuts[c];
    const std::string_view found = near_undefined(cut.joint, dynamics_.cut_pose(c));
    if (!found.empty()) {
      return filled_in(
          found, {.name = {}, .frames = {{mechanism_.links[cut.link_b].name, {}}}, .joints = {}, .coordinate = {}}, {});
    }
  }
  return dead_centre();
}

bool Formulation::rhs(double t, const double* y, double* ydot) {
  if (!all_finite(y, size())) return false;
  go_to(t);
  const double* at = state_for(y);
  if (at == nullptr) return false;
  dynamics_.set_position(at);
  if (!rows_are_defined()) return false;
  if (held_) watch(t, at);
  if (!accelerate(t, at, ydot + nq_)) return false;
  if (rows() > 0 && factorises_rows()) passages_.seen(t, dynamics_.pivot_ratio());
  dynamics_.rate(at, at + nq_, ydot);
  return all_finite(ydot, size());
}

void Formulation::go_to(double t) {
  inputs_.go_to(t);
  if (!targets_.none()) dynamics_.set_targets(targets_.at(t, inputs_));
}

void Formulation::go_to_outputs(double t) {
  inputs_.go_to(t);
  if (!targets_.none()) dynamics_.set_targets(targets_.as_read(t, inputs_));
}

bool Formulation::meet(double t, double* y) {
  go_to(t);
  dynamics_.normalise(y);
  dynamics_.set_position(y);
  renew_factors();  // an impact is no small correction: no former factors will do
  // By the least change in the mass metric, whatever corrects rounding afterwards.
  dynamics_.correct(dynamics_.Phi().data(), dv_.data());
  dynamics_.displace(y, dv_.data());
  if (!close_position(y)) return false;
  renew_factors();
  double* v = y + nq_;
  dynamics_.set_velocity(v);
  dynamics_.correct(dynamics_.row_rates().data(), dv_.data());
  for (int k = 0; k < nv_; ++k) v[k] += dv_[k];
  return close_velocity(v);
}

void Formulation::drives_at(double t, std::vector<double>& out) {
  out.clear();
  const double* s = targets_.at(t, inputs_);
  for (std::size_t i = 0; i < mechanism_.coordinate_rows.size(); ++i) out.insert(out.end(), {s[3 * i], s[3 * i + 1]});
}

void Formulation::allow(long evaluations) {
  const long now = dynamics_.evaluations();
  last_evaluation_ = evaluations < LONG_MAX - now ? now + evaluations : LONG_MAX;
}

void Formulation::renew_factors() {
  refactor();
  factors_ = true;
}

bool Formulation::accelerate(double t, const double* y, double* vdot) {
  renew_factors();
  dynamics_.set_velocity(y + nq_);
  solve(t, vdot);
  return true;
}

void Formulation::solve(double t, double* vdot) {
  const double* known = expected(t);
  dynamics_.solve(u_.data(), vdot, known);
  // Where the last pivot is rounding, so is the direction along which to follow.
  if (known != nullptr && rank_is_lost()) std::copy_n(known, nv_, vdot);
}

bool Formulation::jacobian(double t, const double* y, double* J) {
  ydot_.resize(size());
  count_jacobian();
  if (!rhs(t, y, ydot_.data())) return false;
  Eigen::Map<Eigen::MatrixXd> out(J, size(), size());
  differentiate(ydot_.data() + nq_, out);
  out.topLeftCorner(nq_, nq_) = slopes_.qdot_q;
  out.topRightCorner(nq_, nv_) = slopes_.qdot_v;
  chain(out);
  return out.allFinite();
}

void Formulation::differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) {
  dynamics_.differentiate(u_.data(), inputs(), vdot, slopes_);
  solve_slopes(out);
}

// With r = 0 and c = 0 along the solution, [M J^T; J 0] d(vdot, lambda) = -(dr, dc). slopes_.r is lost.
void Formulation::solve_slopes(Eigen::Map<Eigen::MatrixXd>& out) {
  dynamics_.solve_linear_columns(slopes_.r.data(), slopes_.c.data(), size());
  out.bottomRows(nv_) = -slopes_.r;
}

bool Formulation::project(double, double* y) {
  dynamics_.normalise(y);
  return true;
}

void Formulation::accepted(double t, const double* y) {
  if (!mechanism_.cuts.empty()) turns_.count(t, y);
  if (rows() == 0) return;
  const long before = passages_.count();
  passages_.accepted(t);
  if (passages_.count() > before) events_.add({passages_.last(), Event::singular_position});
}

void Formulation::indicator_values(const double* y, double* g, double* gdot) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  dynamics_.indicators(g, gdot);
}

void Formulation::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  held_from_ = t;
  left_mode_ = INFINITY;
  if (held_) {
    for (int& side : sides_) {
      side = positive[0] ? 1 : positive[1] ? -1 : 0;
      positive += 2;
    }
  }
  dynamics_.hold_branches(held_ ? sides_.data() : nullptr);
}

// Of an evaluation: whether it is outside the mode.
void Formulation::watch(double t, const double* y) {
  if (!(t > held_from_ && t < left_mode_)) return;
  dynamics_.set_velocity(y + nq_);
  dynamics_.branches(present_.data());
  if (present_ != sides_) left_mode_ = t;
}

void Formulation::found_event(double t, int indicator, bool positive) { events_.add({t, indicator, positive}); }

std::string Formulation::too_many_events() const { return events_.too_many(); }

// Not by refactor(): reading outputs must not change the run.
void Formulation::output_accelerations(double t, const double* y, double* vdot) {
  go_to_outputs(t);
  dynamics_.set_position(y);
  dynamics_.factorise();
  judge();
  dynamics_.set_velocity(y + nq_);
  solve(t, vdot);
}

void Formulation::start(const std::vector<double>& cut_q, double t, const double* y) {
  go_to(t);
  turns_.count_from(cut_q, t, y);
  passages_.restart(t);
}

void Formulation::exchange(Record& record) {
  turns_.exchange(record);
  passages_.exchange(record);
  events_.exchange(record);
  record.exchange(jacobians_);
  factors_ = false;
}

// Rounding of the rows' errors [m or rad]: of lengths, and of angles that have counted many turns.
double Formulation::rounding(const double* q) const {
  double largest_q = 0;
  for (int i = 0; i < nq_; ++i) largest_q = std::max(largest_q, std::abs(q[i]));
  return length_ * std::max(closed, 2e-16 * largest_q);
}

bool Formulation::close_position(double* q) {
  dynamics_.normalise(q);
  dynamics_.set_position(q);
  if (mechanism_.rows == 0) return true;
  const double floor = rounding(q);
  double before = INFINITY;
  double moved = 0;
  for (int i = 0; i < 30; ++i) {
    const double gap = largest(dynamics_.Phi());
    if (!std::isfinite(gap)) return false;
    if (gap <= floor) return true;
    // No progress: rounding, or the old factors are too far away.
    if (gap > 0.5 * before && gap <= slack() * floor) return true;
    if (!factors_ || gap > 0.1 * before) renew_factors();
    before = gap;
    correction(dynamics_.Phi().data(), dv_.data());
    moved += largest(dv_);
    if (mechanism_.driven() && !(moved <= elsewhere * length_)) return false;
    dynamics_.displace(q, dv_.data());
    dynamics_.set_position(q);
  }
  return false;
}

bool Formulation::close_velocity(double* v) {
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
    if (!factors_ || gap > 0.1 * before) renew_factors();
    before = gap;
    correction(dynamics_.row_rates().data(), dv_.data());
    for (int k = 0; k < nv_; ++k) v[k] += dv_[k];
    dynamics_.set_velocity(v);
  }
  return false;
}

}  // namespace gelenk
