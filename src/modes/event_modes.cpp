// SPDX-License-Identifier: BSD-3-Clause
#include "modes/event_modes.h"

#include <algorithm>

#include "kinematics/branches.h"

namespace gelenk {

EventModes::EventModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log)
    : dynamics_(dynamics),
      forces_(dynamics.branching()),
      nq_(nq),
      log_(log),
      sides_(static_cast<std::size_t>(forces_.count()), branch_of_state),
      present_sides_(sides_.size()),
      g_(2 * sides_.size()),
      gdot_(g_.size()),
      recorded_sides_(sides_.size()),
      recorded_forces_(sides_.size()),
      holding_(sides_.size()),
      recorded_holding_(static_cast<std::size_t>(forces_.locks())),
      locks_(equations, dynamics, nq, nv, log, sides_) {}

void EventModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  const double* vdot = locks_.accelerations(t, y);
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  locks_.indicators(vdot, g, gdot);
  if (others_ == nullptr) {
    forces_.loads().indicators(g + own_indicators());
    std::fill_n(gdot + own_indicators(), forces_.loads().signed_count(), NAN);
    return;
  }
  others_->indicator_values(t, y, g + own_indicators(), gdot + own_indicators());
  others_->redistribute(t, y, g, g + own_indicators());
}

bool EventModes::recall_mode(double t, double* y) {
  return others_ == nullptr ? locks_.recall(t, y) : others_->recall_mode(t, y);
}

double EventModes::mode_exit_time() const {
  return others_ == nullptr ? mode_exit_time_ : std::min(mode_exit_time_, others_->mode_exit_time());
}

void EventModes::change_mode(double t, double* y) {
  if (others_ == nullptr) {
    hold_mode(t, nullptr);  // stops and signs of loads follow from the state, at which others decide
    return locks_.change(t, y);
  }
  others_->change_mode(t, y);
}

EventModes::Present EventModes::present(double t, const double* y, FrictionTreatment friction) {
  if (locks_.empty()) return {};
  const ModePreview preview(locks_, t, y);
  const int boundary = locks_.treat(friction, t, y);
  return {sides_, boundary};
}

void EventModes::record_outputs() {
  if (locks_.empty()) return;
  recorded_sides_ = sides_;
  recorded_holding_ = locks_.distribute_holding_forces();
  share_holding_forces(forces_, sides_.data(), recorded_holding_.data(), holding_.data());
  dynamics_.readings().branching_forces(forces_.inputs().data(), sides_.data(), holding_.data(),
                                        recorded_forces_.data());
}

void EventModes::record_outputs(std::span<const LockForces> locks) {
  if (locks_.empty()) return;
  recorded_sides_ = sides_;
  std::ranges::fill(holding_, 0.0);
  for (std::size_t i = 0; i < locks.size(); ++i) {
    const Branching::Lock lock = forces_.lock(static_cast<int>(i));
    if (lock.friction >= 0) {
      recorded_sides_[static_cast<std::size_t>(lock.friction)] = locks[i].motion;
      holding_[static_cast<std::size_t>(lock.friction)] = locks[i].friction;
    }
    if (lock.limit < 0) continue;
    recorded_sides_[static_cast<std::size_t>(lock.limit)] = locks[i].contact;
    holding_[static_cast<std::size_t>(lock.limit)] = locks[i].limit;
  }
  dynamics_.readings().branching_forces(forces_.inputs().data(), sides_.data(), holding_.data(),
                                        recorded_forces_.data());
}

void EventModes::remembered_mode(bool* positive) const {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (!locks_.owns(static_cast<int>(i))) continue;
    positive[2 * i] = sides_[i] == 1;
    positive[2 * i + 1] = sides_[i] == -1;
  }
  if (others_ != nullptr) others_->remembered_mode(positive + own_indicators());
}

void EventModes::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  held_from_ = t;
  mode_exit_time_ = INFINITY;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (locks_.owns(static_cast<int>(i))) continue;
    sides_[i] = !held_ ? branch_of_state : positive[2 * i] ? 1 : positive[2 * i + 1] ? -1 : 0;
  }
  forces_.hold(held_ || !locks_.empty() ? sides_.data() : nullptr);
  const bool* following = held_ ? positive + own_indicators() : nullptr;
  if (others_ == nullptr) return forces_.loads().hold_signs(following);
  others_->hold_mode(t, following);
}

void EventModes::check(double t, const double* v) {
  dynamics_.set_velocity(v);
  forces_.sides(present_sides_.data());
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (locks_.keeps_mode(static_cast<int>(i), v)) present_sides_[i] = sides_[i];
  }
  if (present_sides_ != sides_ && is_outside()) mode_exit_time_ = t;
}

// At the boundary of the mode a state belongs to either side, as rounding decides.
bool EventModes::is_outside() {
  locks_.indicators(nullptr, g_.data(), gdot_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (present_sides_[i / 2] == sides_[i / 2]) continue;
    const bool held = sides_[i / 2] == (i % 2 == 0 ? 1 : -1);
    if (held ? g_[i] < 0 : g_[i] > 0) return true;
  }
  return false;
}

std::string EventModes::refusal() const {
  if (const int limit = locks_.state().unstoppable; limit >= 0) {
    return log_.report({0, limit, true}).text +
           ", where no force can stop it: closed loops or prescribed motions determine its motion, which leads beyond";
  }
  if (others_ != nullptr) {
    if (std::string why = others_->refusal(); !why.empty()) return why;
  }
  return log_.too_many();
}

std::string EventModes::indeterminacy() const {
  const int friction = forces_.loads().undetermined();
  if (friction < 0) return {};
  const std::string text = log_.report({0, 2 * friction, true}).text;
  return "the friction of " + text.substr(0, text.find(" slips")) +
         " depends so much on the load of its bearing, guide or gear that no motion, or more than one, agrees with it";
}

void EventModes::found_event(double t, int indicator, bool positive) {
  if (indicator >= own_indicators()) {
    // Where the load of friction changes its sign, no mode changes.
    if (others_ != nullptr) others_->found_event(t, indicator - own_indicators(), positive);
  } else if (!locks_.found_event(indicator)) {
    log_.add({t, indicator, positive});
  }
}

}  // namespace gelenk
