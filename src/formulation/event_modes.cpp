// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/event_modes.h"

#include <algorithm>

#include "linear/box_complementarity.h"
#include "linear/least_load.h"

namespace gelenk {
namespace {

// Speeds up to this fraction of the largest, or of 1, are rest: the rounding of a speed that changes its sign.
constexpr double rest_tolerance = 1e-12;
// Where friction at rest reaches its limit, everything slips whose limit is used up to this fraction, so that what
// breaks away at the same instant does so together.
constexpr double break_away_fraction = 1e-9;
// Relative tolerance of accelerations.
constexpr double acceleration_tolerance = 1e-11;
// Holding forces beyond the limit by less than this fraction are rounding.
constexpr double overload_tolerance = 1e-12;

}  // namespace

EventModes::EventModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log)
    : equations_(equations),
      dynamics_(dynamics),
      forces_(dynamics.branching()),
      nq_(nq),
      log_(log),
      sides_(static_cast<std::size_t>(forces_.count()), JointLoads::of_state),
      present_sides_(sides_.size()),
      g_(2 * sides_.size()),
      gdot_(g_.size()),
      modes_(static_cast<std::size_t>(forces_.locks())),
      triggered_(modes_.size()),
      holding_(modes_.size()),
      vdot_(static_cast<std::size_t>(nv)) {
  if (remembers()) release();
}

void EventModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  if (any_at_rest_) find_holding_forces(t, y);
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  forces_.indicators(g, gdot);
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    if (modes_[i] != 0) continue;
    const int lock = static_cast<int>(i);
    double* of_lock = g + 2 * forces_.force_of(lock);
    of_lock[0] = -holding_[i] - forces_.sticking_limit(lock);
    of_lock[1] = holding_[i] - forces_.sticking_limit(lock);
  }
}

// Brings the holding forces to (t, y); where they are redundant, distributed so that limits are used the least.
void EventModes::find_holding_forces(double t, const double* y) {
  equations_.accelerations_at(t, y, vdot_.data());
  holding_ = forces_.holding_forces();
  if (!forces_.is_redundant()) return;
  const std::vector<int> locks = at_rest();
  Eigen::MatrixXd W;
  forces_.compliance(locks, W);
  Eigen::VectorXd x(static_cast<Eigen::Index>(locks.size()));
  Eigen::VectorXd limits(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    x[i] = holding_[static_cast<std::size_t>(locks[i])];
    limits[i] = forces_.sticking_limit(locks[i]);
  }
  x = least_load(W, W * x, limits);
  for (Eigen::Index i = 0; i < x.size(); ++i) holding_[static_cast<std::size_t>(locks[i])] = x[i];
}

std::vector<int> EventModes::at_rest() const {
  std::vector<int> out;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    if (modes_[i] == 0) out.push_back(static_cast<int>(i));
  }
  return out;
}

bool EventModes::are_exceeded(const std::vector<double>& holding_forces) const {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const double limit = forces_.sticking_limit(static_cast<int>(i)) * (1 + overload_tolerance);
    if (modes_[i] == 0 && std::abs(holding_forces[i]) > limit) return true;
  }
  return false;
}

void EventModes::recall_mode(double t, const double* y) {
  if (!remembers()) return;
  update_modes(t, y, jumped_, true);
  jumped_ = false;
}

void EventModes::preview(double t, const double* y) {
  const long ambiguous = ambiguous_;
  update_modes(t, y, true, false);
  ambiguous_ = ambiguous;
}

// jumped: inputs may have jumped since the modes were determined.
void EventModes::update_modes(double t, const double* y, bool jumped, bool logs) {
  const double* v = y + nq_;
  double fastest = 1;
  for (std::size_t k = 0; k < vdot_.size(); ++k) fastest = std::max(fastest, std::abs(v[k]));
  bool doubtful = false;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const bool rests = std::abs(forces_.speed(static_cast<int>(i), v)) <= rest_tolerance * fastest;
    // What a prescribed motion moves cannot be held; what is about to move may be kept from it by other inputs.
    doubtful = doubtful || (modes_[i] == 0 ? !rests : rests && jumped);
  }
  if (!doubtful && jumped && any_at_rest_) {
    find_holding_forces(t, y);
    doubtful = are_exceeded(holding_);
  }
  if (doubtful) settle(t, y, false, logs);
}

void EventModes::remembered_mode(bool* positive) const {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    bool* of_lock = positive + 2 * forces_.force_of(static_cast<int>(i));
    of_lock[0] = modes_[i] > 0;
    of_lock[1] = modes_[i] < 0;
  }
}

void EventModes::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  held_from_ = t;
  mode_exit_time_ = INFINITY;
  for (int& side : sides_) {
    side = JointLoads::of_state;
    if (held_) {
      side = positive[0] ? 1 : positive[1] ? -1 : 0;
      positive += 2;
    }
  }
  hold_modes();
}

// Holds the remembered modes beside those of stops.
void EventModes::hold_modes() {
  for (std::size_t i = 0; i < modes_.size(); ++i) sides_[forces_.force_of(static_cast<int>(i))] = modes_[i];
  any_at_rest_ = std::ranges::find(modes_, 0) != modes_.end();
  forces_.hold(held_ || remembers() ? sides_.data() : nullptr);
}

void EventModes::release() {
  std::ranges::fill(modes_, JointLoads::released);
  hold_modes();
}

void EventModes::set_modes(const std::vector<int>& modes) {
  modes_ = modes;
  hold_modes();
}

void EventModes::check(double t, const double* v) {
  dynamics_.set_velocity(v);
  forces_.sides(present_sides_.data());
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    if (modes_[i] == 0) present_sides_[forces_.force_of(static_cast<int>(i))] = 0;
  }
  if (present_sides_ != sides_ && is_outside()) mode_exit_time_ = t;
}

// At the boundary of the mode a state belongs to either side, as rounding decides.
bool EventModes::is_outside() {
  forces_.indicators(g_.data(), gdot_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (present_sides_[i / 2] == sides_[i / 2]) continue;
    const bool held = sides_[i / 2] == (i % 2 == 0 ? 1 : -1);
    if (held ? g_[i] < 0 : g_[i] > 0) return true;
  }
  return false;
}

void EventModes::found_event(double t, int indicator, bool positive) {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    if (forces_.force_of(static_cast<int>(i)) != indicator / 2) continue;
    triggered_[i] = 1;
    return;
  }
  log_.add({t, indicator, positive});
}

void EventModes::change_mode(double t, double* y) {
  if (!remembers()) return;
  bool breaks_away = false;
  bool any = false;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    any = any || triggered_[i] != 0;
    breaks_away = breaks_away || (triggered_[i] != 0 && modes_[i] == 0);
  }
  if (!any) return;
  if (!settle(t, y, breaks_away, true) && breaks_away) force_away(t);
  std::ranges::fill(triggered_, 0);
  if (any_at_rest_) forces_.stop(y + nq_);
}

// Lets slip what friction no longer holds, where rounding hides it.
void EventModes::force_away(double t) {
  std::vector<int> modes = modes_;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (triggered_[i] != 0 && modes[i] == 0) modes[i] = holding_[i] > 0 ? -1 : 1;
  }
  enter(t, modes, true);
}

void EventModes::start(double t, const double* y) {
  if (!remembers()) return;
  release();
  jumped_ = false;
  settle(t, y, false, false);
}

// Determines the modes at (t, y). Those that move keep moving; for those at rest, what friction can hold rests, and the
// accelerations decide on the others. breaks_away: friction has reached its limit. Returns whether a mode has changed.
bool EventModes::settle(double t, const double* y, bool breaks_away, bool logs) {
  const std::vector<int> before = modes_;
  const double* v = y + nq_;
  double fastest = 1;
  for (std::size_t k = 0; k < vdot_.size(); ++k) fastest = std::max(fastest, std::abs(v[k]));
  std::vector<int> modes(before);
  std::vector<int> open;  // locks whose mode the accelerations decide
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double speed = forces_.speed(static_cast<int>(i), v);
    const bool rests = std::abs(speed) <= rest_tolerance * fastest || triggered_[i] != 0;
    modes[i] = rests ? JointLoads::released : speed > 0 ? 1 : -1;
    if (rests) open.push_back(static_cast<int>(i));
  }
  if (!open.empty()) {
    modes_ = modes;
    hold_modes();
    equations_.accelerations_at(t, y, vdot_.data());
    Eigen::MatrixXd W;
    forces_.compliance(open, W);
    const auto n = static_cast<Eigen::Index>(open.size());
    Eigen::VectorXd b(n);
    Eigen::VectorXd limits(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = -forces_.speed(open[i], vdot_.data());
      limits[i] = forces_.sticking_limit(open[i]) * (breaks_away ? 1 - break_away_fraction : 1);
    }
    const double size = std::max(b.cwiseAbs().maxCoeff(), (W.cwiseAbs() * limits).maxCoeff());
    std::vector<char> slips(open.size(), 0);
    BoxSolution found;
    for (bool changed = true; changed;) {
      changed = false;
      found = solve_in_box(W, b, -limits, limits);
      for (Eigen::Index i = 0; i < n; ++i) {
        if (slips[i] != 0 || found.at_bound[i] == 0 || std::abs(found.r[i]) <= acceleration_tolerance * size) continue;
        slips[i] = 1;
        changed = limits[i] > forces_.slipping_limit(open[i]) || changed;
        limits[i] = std::min(limits[i], forces_.slipping_limit(open[i]));
      }
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const int direction = -found.at_bound[i];  // friction opposes the motion that begins
      int& mode = modes[static_cast<std::size_t>(open[i])];
      const int previous = before[static_cast<std::size_t>(open[i])];
      const bool keeps = direction != 0 && direction == previous && triggered_[open[i]] == 0;
      mode = slips[i] != 0 && direction != 0 ? direction : keeps ? previous : 0;
      if (slips[i] != 0 && direction == 0) ++ambiguous_;
    }
  }
  modes_ = before;
  enter(t, modes, logs);
  return modes != before;
}

void EventModes::enter(double t, const std::vector<int>& modes, bool logs) {
  bool changed = false;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (modes[i] == modes_[i]) continue;
    changed = true;
    if (!logs) continue;
    const int direction = modes[i] != 0 ? modes[i] : modes_[i];
    log_.add({t, 2 * forces_.force_of(static_cast<int>(i)) + (direction < 0 ? 1 : 0), modes[i] != 0});
  }
  modes_ = modes;
  hold_modes();
  if (changed) equations_.mode_changed();
}

void EventModes::serialize(Archive& archive) {
  if (!remembers()) return;
  for (int& mode : modes_) archive.serialize_in_range(mode, -1, 1);
  archive.serialize(jumped_, ambiguous_);
  hold_modes();
}

}  // namespace gelenk
