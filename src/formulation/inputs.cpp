// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/inputs.h"

#include <algorithm>
#include <cmath>

#include "util/text.h"

namespace gelenk {
namespace {

// A new value this near to the one reached by derivatives is the same up to rounding: relative to the value, and to its
// change in the step, to which the rounding of times is magnified.
constexpr double rounding_tolerance = 1e-10;

// change: bound on that of the input in the last step; 0: it was constant.
bool is_rounding(double value, double reached, double change) {
  return change > 0 && std::abs(value - reached) <= rounding_tolerance * (std::abs(reached) + change);
}

}  // namespace

Inputs::Inputs(std::size_t count, bool has_clock)
    : taylor_(count * orders),
      reached_(count),
      now_(has_clock ? count + 1 : count),
      rates_(2 * count),
      change_(count) {}

double Inputs::derivative_at(int i, int order, double t) const {
  const double s = t - start_;
  double sum = 0;
  for (int k = orders - 1; k > order; --k) sum = (sum + at(i, k)) * s / (k - order);
  return at(i, order) + sum;
}

void Inputs::evaluate(double t) {
  for (std::size_t i = 0; i < count(); ++i) now_[i] = derivative_at(static_cast<int>(i), 0, t);
  if (has_clock()) now_.back() = t;
  now_time_ = t;
}

Inputs::Change Inputs::set(int i, double value) {
  if (!flags_.empty() && flags_[i].motion >= 0) return set_motion(motions_[flags_[i].motion], i, value);
  return set_value(i, value);
}

Inputs::Change Inputs::set_value(int i, double value) {
  const double before = at(i, 0);
  if (value == before) return Change::none;
  at(i, 0) = value;
  if (now_time_ != start_) evaluate(start_);
  now_[i] = value;
  if (is_rounding(value, before, change_[static_cast<std::size_t>(i)])) return Change::smooth;
  update_rates(i);
  return Change::jump;
}

bool Inputs::jumped() const {
  for (std::size_t i = 0; i < reached_.size(); ++i) {
    const double value = at(static_cast<int>(i), 0);
    if (value != reached_[i] && !is_rounding(value, reached_[i], change_[i])) return true;
  }
  return false;
}

void Inputs::note_reached() {
  for (std::size_t i = 0; i < reached_.size(); ++i) reached_[i] = at(static_cast<int>(i), 0);
}

void Inputs::update_rates(int i) {
  for (int order : {1, 2}) rates_[static_cast<std::size_t>(i) * 2 + order - 1] = at(i, order);
}

void Inputs::set_derivative(int i, int order, double value) {
  if (!flags_.empty() && flags_[i].motion >= 0) note_derivative(i, value);
  at(i, order) = value;
  if (!flags_.empty() && flags_[i].motion >= 0) {
    Motion& m = motions_[flags_[i].motion];
    if (m.last > m.first) estimate(m);  // derivatives of the first one
  }
  update_rates(i);
  update_moving();
  if (now_time_ != start_) evaluate(start_);
}

std::string Inputs::fault(int order, double value) {
  if (order < 1 || order > highest_order) {
    return "found a derivative of order " + std::to_string(order) + ", expected one of order 1 to " +
           std::to_string(highest_order);
  }
  if (std::isfinite(value)) return {};
  return "found " + text::number(value) + " for the derivative of order " + std::to_string(order) +
         ", expected a finite number; the previous value is kept";
}

void Inputs::update_moving() {
  moving_ = false;
  for (std::size_t k = 0; k < taylor_.size(); ++k) moving_ = moving_ || (k % orders != 0 && taylor_[k] != 0);
}

void Inputs::start(double t) {
  start_ = now_time_ = t;
  start_motions();
  std::ranges::fill(change_, 0.0);
  changed_ = false;
  for (int i = 0; i < static_cast<int>(count()); ++i) now_[i] = at(i, 0);
  if (has_clock()) now_.back() = t;
  note_reached();
}

void Inputs::finish(double t) {
  interrupt(t);
  if (moving_) {
    for (std::size_t k = 0; k < taylor_.size(); ++k) {
      if (k % orders != 0) taylor_[k] = 0;
    }
    moving_ = false;
  }
  end_motions();
}

void Inputs::interrupt(double t) {
  commit_samples();
  if (moving_) {
    for (int i = 0; i < static_cast<int>(count()); ++i) {
      shift_origin(i, t);
      now_[i] = at(i, 0);
      update_rates(i);
    }
  } else if (changed_) {
    std::ranges::fill(change_, 0.0);
    std::ranges::fill(rates_, 0.0);
  }
  changed_ = moving_;
  if (has_clock()) now_.back() = t;
  start_ = now_time_ = t;
  note_reached();
}

void Inputs::shift_origin(int i, double t) {
  const double s = std::abs(t - start_);
  double bound = 0;
  for (int k = orders - 1; k > 0; --k) bound = (bound + std::abs(at(i, k))) * s / k;
  change_[i] = bound;
  for (int k = 0; k < orders; ++k) at(i, k) = derivative_at(i, k, t);  // uses orders above k, which are shifted later
}

void Inputs::serialize(Archive& archive) {
  archive.serialize(taylor_, reached_, now_, rates_, change_, start_, now_time_, moving_, changed_);
  for (Motion& m : motions_) {
    archive.serialize(m.by_values, m.interrupted, m.sends_derivatives, m.before, m.jump.time, m.jump.size,
                      m.has_jumped);
    m.samples.serialize(archive);
    for (int i = m.first; i <= m.last; ++i)
      archive.serialize(flags_[i].value_set, flags_[i].derivative_set, flags_[i].given);
  }
}

bool operator==(const Inputs& a, const Inputs& b) {
  return a.taylor_ == b.taylor_ && (!a.moving_ || a.start_ == b.start_);
}

}  // namespace gelenk
