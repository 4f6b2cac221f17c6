// SPDX-License-Identifier: BSD-3-Clause
// Inputs that prescribe motions: which derivatives they have, and how those of values alone are estimated.
#include <algorithm>
#include <cmath>

#include "formulation/inputs.h"

namespace gelenk {

void Inputs::add_motion(int i, int derivatives) {
  flags_.resize(count());
  for (int k = 0; k <= derivatives; ++k) flags_[i + k].motion = static_cast<int>(motions_.size());
  motions_.push_back({.first = i, .last = i + derivatives, .samples = {}});
}

double Inputs::given(int i) const {
  const bool by_values = !flags_.empty() && flags_[i].motion >= 0 && motions_[flags_[i].motion].by_values;
  return by_values ? flags_[i].given : at(i, 0);
}

const MotionSamples* Inputs::samples(int i) const {
  if (flags_.empty() || flags_[i].motion < 0) return nullptr;
  const Motion& m = motions_[flags_[i].motion];
  return i == m.last && m.by_values ? &m.samples : nullptr;
}

double estimated_over(const Inputs& inputs) {
  constexpr double steps = 2;  // of whose values estimates are made
  double out = 0;
  for (int i = 0; i < static_cast<int>(inputs.count()); ++i) {
    if (const MotionSamples* const samples = inputs.samples(i)) out = std::max(out, steps * samples->span());
  }
  return out;
}

MotionSamples::Jump Inputs::jump(int i) const {
  if (flags_.empty() || flags_[i].motion < 0) return {};
  const Motion& m = motions_[flags_[i].motion];
  if (i == m.first && m.last > m.first) return m.jump;
  const MotionSamples* of = samples(i);
  return of == nullptr ? MotionSamples::Jump() : of->jump();
}

// Looks for values of a motion that its derivatives, which are inputs, too, do not explain. At the end of a step or of
// a part of it, whose start is still the origin of the polynomials.
void Inputs::find_jump(Motion& m) const {
  constexpr double most_unexplained = 0.5;  // of a change that is no jump
  if (m.last == m.first) return;
  const double value = at(m.first, 0);
  const double size = value - reached_[static_cast<std::size_t>(m.first)];
  const bool follows = !(std::abs(size) > most_unexplained * std::abs(value - m.before));
  m.jump = {};
  if (!follows && m.by_values && !m.has_jumped && MotionSamples::is_visible(size, value)) {
    m.jump = {.time = start_, .size = size};
    m.has_jumped = true;
  }
  m.before = value;
}

Inputs::Change Inputs::set_motion(Motion& m, int i, double value) {
  // Before the rest of a step that has ended early, the same value once more says nothing about the present time.
  if (m.interrupted && value == flags_[i].given && !flags_[i].value_set) return Change::none;
  flags_[i].value_set = true;
  flags_[i].given = value;
  m.sends_derivatives = m.sends_derivatives || i > m.first;
  m.by_values = is_known_by_values(m);
  const Change change = set_value(i, value);
  const bool has_new_rate = estimate(m);
  return has_new_rate && change == Change::none ? Change::smooth : change;
}

// Those of `first` were set, and no inputs have them.
bool Inputs::has_own_derivatives(const Motion& m) const {
  return flags_[m.first].derivative_set && !m.sends_derivatives;
}

// Estimates the derivatives of the motion unless they were set. Returns whether they have changed.
bool Inputs::estimate(Motion& m) {
  if (has_own_derivatives(m)) return false;
  const double first = at(m.first, 1);
  const double second = at(m.first, 2);
  if (!flags_[m.last].derivative_set) {
    clear_derivatives(m.last);
    const MotionSamples::Derivatives found = m.samples.add(start_, at(m.last, 0));
    at(m.last, 1) = found.first;
    at(m.last, 2) = found.second;
  }
  const int variables = m.last - m.first;
  for (int order = 1; variables > 0 && order <= highest_order; ++order) {
    at(m.first, order) = order <= variables ? at(m.first + order, 0) : at(m.last, order - variables);
  }
  for (int i = m.first; i <= m.last; ++i) update_rates(i);
  update_moving();
  if (now_time_ != start_) evaluate(start_);
  return at(m.first, 1) != first || at(m.first, 2) != second;
}

void Inputs::clear_derivatives(int i) {
  for (int order = 1; order <= highest_order; ++order) at(i, order) = 0;
}

// A derivative is about to be set. Zeros set before the start say nothing: masters set all that they have.
void Inputs::note_derivative(int i, double value) {
  Flags& flags = flags_[i];
  if (flags.derivative_set || (value == 0 && !started_)) return;
  clear_derivatives(i);
  flags.derivative_set = true;
}

// Derivatives set since the last step have priority over values, and values over what was before.
bool Inputs::is_known_by_values(const Motion& m) const {
  if (has_own_derivatives(m)) return false;
  for (int i = m.first; i <= m.last; ++i) {
    if (flags_[i].value_set || flags_[i].derivative_set) return true;
  }
  return m.by_values;
}

void Inputs::start_motions() {
  for (Motion& m : motions_) {
    m.sends_derivatives = false;  // zeros may be start values that nobody has set
    for (int i = m.first + 1; i <= m.last; ++i) m.sends_derivatives = m.sends_derivatives || at(i, 0) != 0;
    m.by_values = !has_own_derivatives(m);
    m.interrupted = m.has_jumped = false;
    m.samples.clear();
    m.before = NAN;
    m.jump = {};
    for (int i = m.first; i <= m.last; ++i) {
      flags_[i].value_set = false;
      flags_[i].given = at(i, 0);
    }
    estimate(m);
  }
  started_ = true;
}

// A step, or a part of it, ends; the origin of the polynomials is still its start.
void Inputs::commit_samples() {
  for (Motion& m : motions_) {
    find_jump(m);
    const bool has_rate = m.last == m.first || flags_[m.last].derivative_set;
    if (!m.by_values && has_rate) m.samples.add(start_, at(m.last, 0), at(m.last, 1));
    m.samples.commit();
    m.interrupted = true;
    for (int i = m.first; i <= m.last && m.by_values; ++i) flags_[i].value_set = false;
  }
}

void Inputs::end_motions() {
  for (Motion& m : motions_) {
    m.interrupted = false;
    for (int i = m.first; i <= m.last; ++i) {
      flags_[i].value_set = flags_[i].derivative_set = false;
      if (!m.by_values) flags_[i].given = at(i, 0);
    }
  }
}

}  // namespace gelenk
