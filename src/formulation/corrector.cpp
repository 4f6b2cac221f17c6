// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/corrector.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

// Of the rows, relative to the mechanism's size: some tens of roundings.
constexpr double closure_tolerance = 1e-14;
constexpr int most_iterations = 30;
// A gap that shrinks less than this in an iteration makes no progress; and by old factors, asks for new ones.
constexpr double stalled = 0.5;
constexpr double slow = 0.1;
// Share of the mechanism's size [m], or rad for each metre of it, that corrections may move a driven one: beyond it
// lies another assembly, where a motion leads that the loops cannot follow.
constexpr double farthest = 0.3;

double largest(const std::vector<double>& x) {
  double max = 0;
  for (const double value : x) {
    if (!(std::abs(value) <= max)) max = std::abs(value);  // also takes a NaN, and keeps it
  }
  return max;
}

double size_of(const Mechanism& mechanism) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  return length;
}

}  // namespace

Corrector::Corrector(const Mechanism& mechanism, Dynamics& dynamics)
    : mechanism_(mechanism), dynamics_(dynamics), length_(size_of(mechanism)), dv_(mechanism.nv) {}

void Corrector::refactorize() {
  refactor();
  has_factors_ = true;
}

// Rounding of the rows' errors [m or rad]: of lengths, and of angles that have counted many turns.
double Corrector::rounding(const double* q) const {
  double largest_q = 0;
  for (int i = 0; i < mechanism_.nq; ++i) largest_q = std::max(largest_q, std::abs(q[i]));
  return length_ * std::max(closure_tolerance, 2e-16 * largest_q);
}

bool Corrector::close_position(double* q) {
  dynamics_.normalize(q);
  dynamics_.set_position(q);
  if (mechanism_.rows == 0) return true;
  const double floor = rounding(q);
  double before = INFINITY;
  double moved = 0;
  for (int i = 0; i < most_iterations; ++i) {
    const double gap = largest(dynamics_.Phi());
    if (!std::isfinite(gap)) return false;
    if (gap <= floor) return true;
    // No progress: rounding, or the old factors are too far away.
    if (gap > stalled * before && gap <= slack() * floor) return true;
    if (!has_factors_ || gap > slow * before) refactorize();
    before = gap;
    min_norm_displacement(dynamics_.Phi().data(), dv_.data());
    moved += largest(dv_);
    if (mechanism_.driven() && !(moved <= farthest * length_)) return false;
    dynamics_.displace(q, dv_.data());
    dynamics_.set_position(q);
  }
  return false;
}

bool Corrector::close_velocity(double* v) {
  dynamics_.set_velocity(v);
  if (mechanism_.rows == 0) return true;
  double before = INFINITY;
  for (int i = 0; i < most_iterations; ++i) {
    const double gap = largest(dynamics_.row_rates());
    if (!std::isfinite(gap)) return false;
    double speed = 1;
    for (int k = 0; k < mechanism_.nv; ++k) speed = std::max(speed, std::abs(v[k]));
    const double floor = closure_tolerance * length_ * speed;
    if (gap <= floor) return true;
    if (gap > stalled * before && gap <= slack() * floor) return true;
    if (!has_factors_ || gap > slow * before) refactorize();
    before = gap;
    min_norm_displacement(dynamics_.row_rates().data(), dv_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += dv_[k];
    dynamics_.set_velocity(v);
  }
  return false;
}

}  // namespace gelenk
