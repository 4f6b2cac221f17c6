// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/constraint_projector.h"

#include <algorithm>
#include <cmath>

#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

// Error of the constraint equations relative to the length of the mechanism: some tens of roundings.
constexpr double closure_tolerance = 1e-14;
constexpr int most_projections = 30;
// Ratio of successive errors above which an iteration makes no progress.
constexpr double stall_ratio = 0.5;
// Limit on the corrections of a driven mechanism, as a fraction of its length [m], or in rad per meter of it: beyond it
// lies another assembly, reached when a prescribed motion leads where the loops cannot follow.
constexpr double max_correction_fraction = 0.3;

double largest_size(const std::vector<double>& x) {
  double max = 0;
  for (const double value : x) {
    if (!(std::abs(value) <= max)) max = std::abs(value);  // keeps NaN
  }
  return max;
}

double size_of(const Mechanism& mechanism) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  return length;
}

}  // namespace

ConstraintProjector::ConstraintProjector(const Mechanism& mechanism, Dynamics& dynamics)
    : mechanism_(mechanism), dynamics_(dynamics), length_(size_of(mechanism)), dv_(mechanism.nv) {}

void ConstraintProjector::refactorize() {
  refactor();
  has_factors_ = true;
}

double ConstraintProjector::most_corrected() const {
  return mechanism_.driven() ? max_correction_fraction * length_ : INFINITY;
}

// Rounding error of the constraint equations [m or rad]: of lengths, and of angles after many revolutions.
double ConstraintProjector::rounding(const double* q) const {
  double largest_q = 0;
  for (int i = 0; i < mechanism_.nq; ++i) largest_q = std::max(largest_q, std::abs(q[i]));
  return length_ * std::max(closure_tolerance, 2e-16 * largest_q);
}

bool ConstraintProjector::close_position(double* q) {
  dynamics_.normalize(q);
  dynamics_.set_position(q);
  if (mechanism_.rows == 0) return true;
  const double floor = rounding(q);
  const double most = most_corrected();
  double before = INFINITY;
  double moved = 0;
  for (int i = 0; i < most_projections; ++i) {
    const double gap = largest_size(dynamics_.Phi());
    if (!std::isfinite(gap)) return false;
    if (gap <= floor) return true;
    // No progress: rounding, or the old factors are too inaccurate.
    if (gap > stall_ratio * before && gap <= slack() * floor) return true;
    if (!has_factors_ || gap > renewal_ratio() * before) refactorize();
    before = gap;
    min_norm_displacement(dynamics_.Phi().data(), dv_.data());
    moved += largest_size(dv_);
    if (!(moved <= most)) return false;
    dynamics_.displace(q, dv_.data());
    dynamics_.set_position(q);
  }
  return false;
}

bool ConstraintProjector::close_velocity(double* v) {
  dynamics_.set_velocity(v);
  if (mechanism_.rows == 0) return true;
  double before = INFINITY;
  for (int i = 0; i < most_projections; ++i) {
    const double gap = largest_size(dynamics_.row_rates());
    if (!std::isfinite(gap)) return false;
    double speed = 1;
    for (int k = 0; k < mechanism_.nv; ++k) speed = std::max(speed, std::abs(v[k]));
    const double floor = closure_tolerance * length_ * speed;
    if (gap <= floor) return true;
    if (gap > stall_ratio * before && gap <= slack() * floor) return true;
    if (!has_factors_ || gap > renewal_ratio() * before) refactorize();
    before = gap;
    min_norm_displacement(dynamics_.row_rates().data(), dv_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += dv_[k];
    dynamics_.set_velocity(v);
  }
  return false;
}

}  // namespace gelenk
