// SPDX-License-Identifier: BSD-3-Clause
// Projection near singular configurations (projection.cpp).
#pragma once

#include <algorithm>

#include "formulation/constraint_projector.h"
#include "formulation/recorded_motion.h"

namespace gelenk {

// Projects by the smallest step in the mass metric; along weak directions only as far as these are accurate.
class WeakRowCorrector final : public ConstraintProjector {
 public:
  static constexpr double regular_fraction = 0.1;  // below it, rows are weak
  // Of a program's pivots: accelerations are recorded below half the largest pivot ratio (projection.cpp), which a
  // program does not know.
  static constexpr double fraction_to_look = 0.8;
  static constexpr double default_weak_fraction = 0.003;

  // best_pivot_ratio: largest ratio known before the run, read when it is needed; null: unknown.
  WeakRowCorrector(const Mechanism& mechanism, Dynamics& dynamics, const double* best_pivot_ratio)
      : ConstraintProjector(mechanism, dynamics), best_known_pivot_ratio_(best_pivot_ratio) {}

  // The factors are those of the last evaluation of `of`, which are not near a singular configuration.
  void use_factors_of(RecordedMotion& of) {
    recorded_ = &of;
    best_pivot_ratio_ = std::max(best_pivot_ratio_, of.usual_pivot_ratio());
    has_other_factors();
    if (regular_) return;
    regular_ = true;
    set_weak(0);
  }
  void min_norm_displacement(const double* residual, double* dv) override {
    recorded_ != nullptr ? recorded_->displace(residual, dv) : ConstraintProjector::min_norm_displacement(residual, dv);
  }
  // Whether these are not far from where rows become weak.
  bool may_become_weak() const { return recorded_ != nullptr && recorded_->pivot_fraction() < fraction_to_look; }
  // Whether the last factors are not near a singular configuration.
  bool is_regular() const { return regular_; }
  // Pivot ratio relative to the largest one.
  double pivot_fraction() const { return dynamics_.pivot_ratio() / best_pivot_ratio_; }
  // The same, also by what was known before the run; 0: weak rows have not been corrected in full.
  double singular_distance() const {
    if (recorded_ != nullptr) return 1;
    const double best = std::max(best_pivot_ratio_, best_known());
    return regular_ && best > 0 ? dynamics_.pivot_ratio() / best : 0;
  }
  bool below(double pivot_fraction) const {
    return recorded_ == nullptr && dynamics_.pivot_ratio() < pivot_fraction * best_pivot_ratio_;
  }
  // At the start of a run: determines from earlier knowledge whether that is near a singular configuration.
  void assess_start() {
    if (!(dynamics_.pivot_ratio() < regular_fraction * best_known())) return;
    best_pivot_ratio_ = std::max(best_pivot_ratio_, best_known());
    update_singularity_status();
  }
  // Whether the mechanism narrowly misses the singular configuration: then no row is weak.
  void set_near_miss(bool is_one) {
    if (is_one == is_near_miss_) return;
    is_near_miss_ = is_one;
    update_singularity_status();
  }
  void update_singularity_status() {
    regular_ = is_near_miss_ || !below(regular_fraction);
    set_weak(regular_ ? 0 : default_weak_fraction);
  }
  void factors_changed() override { update_singularity_status(); }
  void set_weak(double pivot_fraction) {
    if (!full_correction_ || pivot_fraction == 0) dynamics_.set_singular_threshold(pivot_fraction * best_pivot_ratio_);
  }
  // Corrects weak directions in full, since a long step may leave too large errors in them.
  bool close_in_full(double* q, double* v) {
    full_correction_ = true;
    dynamics_.set_singular_threshold(0);
    refactor();
    const bool closed = close_position(q) && close_velocity(v);
    full_correction_ = false;
    return closed;
  }
  void serialize(Archive& archive) {
    archive.serialize(best_pivot_ratio_, is_near_miss_);
    if (archive.reading()) full_correction_ = false;
  }

 private:
  double best_known() const { return best_known_pivot_ratio_ == nullptr ? 0 : *best_known_pivot_ratio_; }
  void refactor() override {
    recorded_ = nullptr;
    dynamics_.factorize();
    best_pivot_ratio_ = std::max(best_pivot_ratio_, dynamics_.pivot_ratio());
    update_singularity_status();
  }
  // Errors left along weak directions are small, and decay where the constraints are regular again.
  double slack() const override { return regular_ ? ConstraintProjector::slack() : 1e8; }

  const double* best_known_pivot_ratio_;
  RecordedMotion* recorded_ = nullptr;  // of which the factors are
  double best_pivot_ratio_ = 0;  // largest in the run, or known before it if it starts near a singular configuration
  bool regular_ = true;
  bool is_near_miss_ = false;
  bool full_correction_ = false;  // weak directions are corrected in full
};

}  // namespace gelenk
