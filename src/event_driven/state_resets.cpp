// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/state_resets.h"

#include <cmath>

#include "dynamics/law_kinks.h"
#include "event/event_source.h"
#include "kinematics/loads.h"

namespace gelenk {
namespace {

// At the same instant.
constexpr int most_rounds = 50;

}  // namespace

StateResets::StateResets(const Loads& loads, Dynamics& dynamics, ModeEquations& equations, int nq, int nv)
    : loads_(loads),
      dynamics_(dynamics),
      equations_(equations),
      nq_(nq),
      first_state_(static_cast<std::size_t>(nq + nv)),
      vdot_(static_cast<std::size_t>(nv)),
      g_(loads.resets.empty() ? 0 : static_cast<std::size_t>(dynamics.kinks().count())),
      gdot_(g_.size()),
      positive_(std::make_unique<bool[]>(g_.size())),
      held_(g_.empty() ? 0 : loads.resets.size(), 0),  // conditions that are constant never become true
      when_(held_.size()),
      to_(held_.size()) {}

// On the branches on which a step from y is: where events are located, what decides on them may be exactly 0.
void StateResets::evaluate(double t, const double* y) {
  LawKinks& kinks = dynamics_.kinks();
  const bool* const before = kinks.held().data();
  kinks.hold(nullptr);
  const bool needs_accelerations = kinks.need_accelerations();
  if (needs_accelerations) equations_.accelerations_at(t, y, vdot_.data());
  equations_.bring_inputs(t, y);
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  kinks.indicators(needs_accelerations ? vdot_.data() : nullptr, g_.data(), gdot_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) positive_[i] = is_positive(g_[i], gdot_[i]);
  kinks.hold(positive_.get());
  kinks.resets(when_.data(), to_.data());
  kinks.hold(before);
}

void StateResets::start(double t, const double* y) {
  refusal_ = {};
  if (held_.empty()) return;
  evaluate(t, y);
  for (std::size_t i = 0; i < held_.size(); ++i) held_[i] = when_[i] > 0 ? 1 : 0;
}

bool StateResets::apply(double t, double* y) {
  if (held_.empty()) return false;
  for (int round = 0; round < most_rounds; ++round) {
    evaluate(t, y);
    int jumped = -1;  // the resets of a state follow each other
    for (std::size_t i = 0; i < held_.size(); ++i) {
      const bool becomes_true = when_[i] > 0 && held_[i] == 0;
      held_[i] = when_[i] > 0 ? 1 : 0;
      const int state = loads_.resets[i].state;
      if (!becomes_true || state == jumped) continue;
      jumped = state;
      if (std::isfinite(to_[i])) {
        y[first_state_ + static_cast<std::size_t>(state)] = to_[i];
      } else {
        refusal_ = "a reset of an element state has no finite value";
      }
    }
    if (jumped < 0) return round > 0;
  }
  refuse_repetition();
  return true;
}

void StateResets::serialize(Archive& archive) {
  if (held_.empty()) return;
  archive.serialize(held_);
  if (archive.reading()) refusal_ = {};
}

}  // namespace gelenk
