// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/revolution_counter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

// Mean velocity of an angle over a step, used to identify the turn. A rod that passes close to the axis on its neighbor
// rotates fast for a short time; its rotation in the step is less than half a turn, and the slower of both ends is the
// better estimate.
double mean_speed(const Cut& cut, double before, double after) {
  if (!cut.is_rod()) return (before + after) / 2;
  if (before * after <= 0) return 0;
  return std::abs(before) < std::abs(after) ? before : after;
}

}  // namespace

RevolutionCounter::RevolutionCounter(const Mechanism& mechanism, Dynamics& dynamics)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      q_(mechanism.cut_nq),
      v_(mechanism.cut_nv),
      v_last_(mechanism.cut_nv),
      kept_{q_, v_last_} {}

void RevolutionCounter::count_from(const std::vector<double>& cut_q, double t, const double* y) {
  q_ = cut_q;
  last_time_ = t;
  std::ranges::fill(v_last_, 0.0);
  count(t, y);
}

void RevolutionCounter::serialize(Archive& archive) {
  archive.serialize(q_, v_last_, last_time_);
  dynamics_.set_cut_reference(q_.data());
}

void RevolutionCounter::keep() {
  kept_.q = q_;
  kept_.v = v_last_;
  kept_.time = last_time_;
}

void RevolutionCounter::return_to_kept() {
  q_ = kept_.q;
  v_last_ = kept_.v;
  last_time_ = kept_.time;
  dynamics_.set_cut_reference(q_.data());
}

void RevolutionCounter::count(double t, const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + mechanism_.nq);
  const double h = t - last_time_;
  for (std::size_t c = 0; c < mechanism_.cuts.size(); ++c) {
    const Cut& cut = mechanism_.cuts[c];
    dynamics_.readings().cut_speeds(static_cast<int>(c), v_.data() + cut.iv);
    double found[max_cut_nq];
    std::copy_n(q_.data() + cut.iq, cut.nq, found);
    dynamics_.cut_coordinates(static_cast<int>(c), found);
    for (int i = 0; i < cut.nq; ++i) {
      double& q = q_[cut.iq + i];
      if (cut.is_angle[i]) {
        const double expected = q + h * mean_speed(cut, v_last_[cut.iv + i], v_[cut.iv + i]);
        found[i] += 2 * std::numbers::pi * std::round((expected - found[i]) / (2 * std::numbers::pi));
      }
      q = found[i];
    }
  }
  v_last_ = v_;
  last_time_ = t;
  dynamics_.set_cut_reference(q_.data());
}

}  // namespace gelenk
