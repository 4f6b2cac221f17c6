// SPDX-License-Identifier: BSD-3-Clause
// `projection`: the index-1 form
//   qdot = N v,   [M J^T; J 0] [vdot; lambda] = [tau - h; gamma],
// with q and v projected onto Phi = 0, J v = b after every accepted step by the smallest correction in the mass metric
// (Eich 1993; Blajer 2002), so that neither drifts. Factors of the last evaluation are reused. Across singular
// configurations the accelerations in the weak direction are extrapolated from before.
#include <algorithm>
#include <cmath>

#include "event_driven/contact_modes.h"
#include "formulation/branch_acceleration.h"
#include "formulation/formulation.h"
#include "formulation/singular_approach.h"
#include "formulation/weak_row_corrector.h"

namespace gelenk {
namespace {

// Crossing a singular configuration (a change point, a dead center). Near it the component of vdot in the weak
// direction is a quotient of two numbers that vanish together, and the rounding and step errors in it move the
// mechanism onto another branch; smaller steps only come nearer. Therefore, as fractions of the largest pivot ratio
// observed:
constexpr double near_fraction = 0.5;  // below it the accelerations of accepted steps are recorded
constexpr double regular_fraction = WeakRowCorrector::regular_fraction;  // they are extrapolated below it instead ...
constexpr double min_spacing = 0.05;         // ... from fractions this far apart, so that the polynomial reaches far
constexpr double max_weak_fraction = 0.02;   // ... and near and below weak_fraction() they replace the weak component;
constexpr double min_weak_fraction = 0.001;  // the fraction is smaller if they are less accurate
constexpr double default_weak_fraction = WeakRowCorrector::default_weak_fraction;  // if their accuracy is unknown
constexpr double constraint_noise = 1e-14;
constexpr double rounding_fraction = 1e-5;  // below it even the weak direction is rounding
constexpr double max_magnification = 1e4;
// With these values N-four-bars with 1, 2, 10 and 40 loops keep to their branch for 20 s (56 crossings) within 3e-7 m
// at tolerances of 1e-6 to 1e-10; values three times as large or small serve nearly as well.

// Rounding level of constraint errors relative to the length of the mechanism. With 8e-16 an engine with six loops
// takes a hundred times as many steps with cvode at 1e-10.
constexpr double constraint_rounding = 3e-16;

// The pivot fraction below which extrapolated accelerations with this error are used. There the accelerations from the
// constraint equations have errors of constraint_noise / fraction^3: rounding moves a state off its branch by 1e-16 /
// fraction, its velocities by that divided by the fraction again, and so on.
double weak_fraction(double error, double size) {
  if (!(error * max_weak_fraction * max_weak_fraction * max_weak_fraction > constraint_noise * size))
    return max_weak_fraction;
  return std::max(min_weak_fraction, std::cbrt(constraint_noise * size / error));
}

class Projection final : public Formulation {
 public:
  explicit Projection(const FormulationContext& context)
      : Formulation(context),
        corrections_(context.options.corrections),
        program_(context.program),
        correction_(mechanism_.nv),
        rows_(mechanism_, dynamics_, context.options.best_pivot_ratio),
        extrapolated_(mechanism_.nv),
        vdot_before_(mechanism_.nv),
        vdot_after_(mechanism_.nv),
        recorded_inputs_(context.inputs) {
    jacobians_.of_rows = false;
    for (const Link& link : mechanism_.links) rounding_level_ += constraint_rounding * link.X_PJ.p.norm();
    for (auto& acceleration : accelerations_) acceleration.resize(mechanism_.nv);
  }
  bool project(double t, double* y) override;
  void polish(bool on) override { polishing_ = on; }
  double singular_distance() const override { return mechanism_.cuts.empty() ? 1 : rows_.singular_distance(); }
  double end_of_step(double t) override { return recorded_ > 1 ? approach_.end_of_step(t) : INFINITY; }
  void accepted(double t, const double* y) override;
  void start(const std::vector<double>& cut_q, double t, const double* y) override;
  void inputs_changed(double t, const double* y) override;
  void mode_changed() override { forget_accelerations(); }  // they have jumped
  void serialize(Archive& archive) override;

 private:
  ConstraintProjector& projector() override { return rows_; }
  void solve(double t, double* vdot) override;
  const RecordedMotion* evaluate_by_program(const double* y, double* ydot) override {
    if (program_ == nullptr || !modes().is_in_motion() ||
        !program_->evaluate(y, drives_.u().data(), modes().outputs().held_sides().data(), ydot))
      return nullptr;
    rows_.use_factors_of(*program_);
    return program_;
  }
  void forget_accelerations() {
    recorded_ = 0;
    approach_.clear();
  }
  const double* extrapolate(double t);
  double lagrange(double t, int first, double* weights) const;
  void add_jump(double t);
  void start_on_branch(double t, const double* y);
  void record_acceleration(double t, const double* y);
  void compare_accelerations(double t, const double* y);
  bool apply_fixed_corrections(double* q, double* v);
  bool close(double* y);
  bool close_contacts(double* y);
  double kinetic_energy(const double* v);
  // Whether extrapolations are of states on the way in. A start near a singular configuration has errors of its own.
  bool may_be_compared() const { return recorded_ > (started_on_branch_ ? 1 : 0); }

  int corrections_;
  RecordedMotion* program_;         // of the equations; null: the kernels evaluate all
  double rounding_level_ = 0;       // m or rad, from the mechanism's length
  std::vector<double> correction_;  // displacement of one projection step
  WeakRowCorrector rows_;

  // Accelerations at the last times at which the constraints were regular.
  static constexpr int max_recorded = 8;
  int recorded_ = 0;
  bool started_on_branch_ = false;  // the first of them is that of the branch on which the run started
  double times_[max_recorded] = {};
  double fractions_[max_recorded] = {};  // pivot ratios there, relative to the largest
  std::vector<double> accelerations_[max_recorded];
  std::vector<double> extrapolated_, vdot_before_, vdot_after_;
  Inputs recorded_inputs_;  // inputs of the recorded accelerations
  bool polishing_ = false;
  SingularApproach approach_;
  double energy_before_ = 0, energy_after_ = 0;  // kinetic [J], of the last projection of velocities
};

void Projection::start(const std::vector<double>& cut_q, double t, const double* y) {
  forget_accelerations();
  rows_.set_near_miss(false);
  started_on_branch_ = false;
  Formulation::start(cut_q, t, y);
  start_on_branch(t, y);
}

// In or near a singular configuration without recorded accelerations, those of the branch are used.
void Projection::start_on_branch(double t, const double* y) {
  if (mechanism_.cuts.empty() || mechanism_.rows == 0 || mechanism_.driven()) return;
  dynamics_.set_position(y);
  rows_.refactorize();
  rows_.assess_start();
  if (rows_.is_regular()) return;
  if (!BranchAcceleration(mechanism_, dynamics_)
           .find(y, y + mechanism_.nq, drives_.u().data(), accelerations_[0].data()))
    return;
  recorded_ = 1;
  started_on_branch_ = true;
  times_[0] = t;
  recorded_inputs_ = drives_.inputs();
  dynamics_.set_position(y);
  rows_.refactorize();
  fractions_[0] = rows_.pivot_fraction();
}

void Projection::inputs_changed(double t, const double* y) {
  Formulation::inputs_changed(t, y);
  if (!started_on_branch_ || recorded_ != 1 || times_[0] != t) return;
  drives_.go_to(t, y);
  recorded_ = 0;
  start_on_branch(t, y);
}

void Projection::serialize(Archive& archive) {
  Formulation::serialize(archive);
  if (program_ != nullptr) program_->serialize(archive, revolutions().coordinates());
  rows_.serialize(archive);
  archive.serialize_in_range(recorded_, 0, max_recorded);
  archive.serialize(started_on_branch_);
  approach_.serialize(archive);
  if (recorded_ == 0) return;
  recorded_inputs_.serialize(archive);
  for (int i = 0; i < recorded_; ++i) {
    archive.serialize(times_[i], fractions_[i], accelerations_[i]);
  }
}

void Projection::solve(double t, double* vdot) {
  const double* extrapolated = extrapolate(t);
  dynamics_.solve(drives_.u().data(), vdot, extrapolated);
  // If the last pivot is rounding, so is the weak direction.
  if (extrapolated != nullptr && rows_.below(rounding_fraction)) std::copy_n(extrapolated, mechanism_.nv, vdot);
}

// Weights of the accelerations recorded from `first` on in the interpolation polynomial at t; returns the sum of their
// absolute values.
double Projection::lagrange(double t, int first, double* weights) const {
  double sum = 0;
  for (int i = first; i < recorded_; ++i) {
    weights[i] = 1;
    for (int j = first; j < recorded_; ++j) {
      if (j != i) weights[i] *= (t - times_[j]) / (times_[i] - times_[j]);
    }
    sum += std::abs(weights[i]);
  }
  return sum;
}

// Extrapolates the recorded accelerations by a polynomial in time through as many of the latest as do not magnify their
// rounding too much; null: none are recorded.
const double* Projection::extrapolate(double t) {
  if (rows_.is_regular() || recorded_ == 0) return nullptr;
  double weights[max_recorded];
  double fewer[max_recorded] = {};
  int first = 0;
  while (lagrange(t, first, weights) > max_magnification) ++first;  // a single one magnifies nothing
  if (first + 1 < recorded_) lagrange(t, first + 1, fewer);
  double error = 0;
  double size = 0;
  for (int k = 0; k < mechanism_.nv; ++k) {
    double sum = 0;
    double without = 0;
    for (int i = first; i < recorded_; ++i) {
      sum += weights[i] * accelerations_[i][k];
      if (i > first) without += fewer[i] * accelerations_[i][k];
    }
    extrapolated_[k] = sum;
    error = std::max(error, std::abs(sum - without));
    size = std::max(size, std::abs(sum));
  }
  const bool has_error_estimate = first + 1 < recorded_;
  rows_.set_weak(has_error_estimate ? weak_fraction(error, size) : default_weak_fraction);
  if (drives_.inputs() != recorded_inputs_) add_jump(t);
  return extrapolated_.data();
}

// Adds the effect of changed inputs. Errors of the state, which become large in vdot near a singular configuration, are
// the same in both terms and cancel.
void Projection::add_jump(double t) {
  recorded_inputs_.go_to(t);
  dynamics_.solve(drives_.u(recorded_inputs_).data(), vdot_before_.data());
  dynamics_.solve(drives_.u().data(), vdot_after_.data());
  for (int k = 0; k < mechanism_.nv; ++k) extrapolated_[k] += vdot_after_[k] - vdot_before_[k];
}

// Records the acceleration at the state accepted at t, the present state of `dynamics`.
void Projection::record_acceleration(double t, const double* y) {
  drives_.go_to(t, y);
  rows_.refactorize();
  approach_.pass(t, rows_.pivot_fraction());
  if (!rows_.is_regular()) return compare_accelerations(t, y);
  if (rows_.below(regular_fraction)) return;  // a near miss
  if (drives_.inputs() != recorded_inputs_) {
    recorded_ = 0;
    started_on_branch_ = false;
    recorded_inputs_ = drives_.inputs();
  }
  if (recorded_ > 0 && t <= times_[recorded_ - 1]) return;
  const double pivot_fraction = rows_.pivot_fraction();
  // The last one is replaced by a later one as long as it is too close to the one before.
  const bool too_close = recorded_ > 1 && std::abs(pivot_fraction - fractions_[recorded_ - 2]) < min_spacing;
  if (too_close) --recorded_;
  if (recorded_ == max_recorded) {
    std::rotate(times_, times_ + 1, times_ + max_recorded);
    std::rotate(fractions_, fractions_ + 1, fractions_ + max_recorded);
    std::rotate(accelerations_, accelerations_ + 1, accelerations_ + max_recorded);
    --recorded_;
  }
  times_[recorded_] = t;
  fractions_[recorded_] = pivot_fraction;
  dynamics_.solve(drives_.u().data(), accelerations_[recorded_].data());
  ++recorded_;
}

// Compares the extrapolated accelerations at an accepted state with those of the equations.
void Projection::compare_accelerations(double t, const double* y) {
  const double* extrapolated = extrapolate(t);
  if (!may_be_compared() || extrapolated == nullptr) return;
  dynamics_.solve(drives_.u().data(), vdot_after_.data());
  double deviation = 0;
  double size = 0;
  for (int k = 0; k < mechanism_.nv; ++k) {
    deviation = std::max(deviation, std::abs(vdot_after_[k] - extrapolated[k]));
    size = std::max({size, std::abs(extrapolated[k]), y[mechanism_.nq + k] * y[mechanism_.nq + k]});
  }
  const double fraction = rows_.pivot_fraction();
  approach_.compare(fraction, deviation, size, constraint_noise * size / (fraction * fraction * fraction));
  approach_.remove_energy(energy_before_, energy_after_, modes().locks().tolerance());
  rows_.set_near_miss(approach_.misses());
}

// A fixed number of corrections with the present factors, at constant cost, regardless of the remaining error.
bool Projection::apply_fixed_corrections(double* q, double* v) {
  dynamics_.normalize(q);
  dynamics_.set_position(q);
  for (int i = 0; i < corrections_; ++i) {
    rows_.min_norm_displacement(dynamics_.Phi().data(), correction_.data());
    dynamics_.displace(q, correction_.data());
    dynamics_.set_position(q);
  }
  dynamics_.set_velocity(v);
  for (int i = 0; i < corrections_; ++i) {
    rows_.min_norm_displacement(dynamics_.row_rates().data(), correction_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += correction_[k];
    dynamics_.set_velocity(v);
  }
  return std::ranges::all_of(dynamics_.row_rates(), [](double rate) { return std::isfinite(rate); });
}

// Newton's method stops at an error of some tens of roundings, so it leaves anything between zero and that. Divided by
// a short lever arm this acts as noise in the error estimates of multistep methods, magnified by differences of order
// six. If the error exceeds rounding, one more correction with the present factors removes it.
bool Projection::close(double* y) {
  if (!rows_.close_position(y)) return false;
  double* v = y + mechanism_.nq;
  const bool polishes = (polishing_ || !rows_.is_regular()) && rows_.has_factors() && mechanism_.rows > 0;
  const auto left = [](const std::vector<double>& gaps) {
    double max = 0;
    for (const double gap : gaps) max = std::max(max, std::abs(gap));
    return max;
  };
  if (polishes && left(dynamics_.Phi()) > rounding_level_) {
    if (!rows_.is_regular()) rows_.refactorize();
    rows_.min_norm_displacement(dynamics_.Phi().data(), correction_.data());
    dynamics_.displace(y, correction_.data());
    dynamics_.set_position(y);
  }
  const bool extrapolates = !rows_.is_regular() && may_be_compared();
  energy_before_ = extrapolates ? kinetic_energy(v) : 0;
  if (!rows_.close_velocity(v)) return false;
  energy_after_ = extrapolates ? kinetic_energy(v) : 0;
  double speed = 1;
  for (int k = 0; k < mechanism_.nv; ++k) speed = std::max(speed, std::abs(v[k]));
  if (polishes && left(dynamics_.row_rates()) > rounding_level_ * speed) {
    rows_.min_norm_displacement(dynamics_.row_rates().data(), correction_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += correction_[k];
  }
  return true;
}

double Projection::kinetic_energy(const double* v) {
  dynamics_.set_velocity(v);
  return dynamics_.readings().energy().kinetic;
}

bool Projection::project(double t, double* y) {
  drives_.go_to(t, y);
  if (impulses()->are_used()) {
    rows_.discard_factors();  // those of the middle of the step
    rows_.factors_changed();
  }
  if (corrections_ > 0 && mechanism_.rows > 0) return apply_fixed_corrections(y, y + mechanism_.nq);
  if (!rows_.is_regular()) rows_.update_singularity_status();  // the last accelerations used another weak fraction
  const bool closed = close(y) || (!rows_.is_regular() && rows_.close_in_full(y, y + mechanism_.nq));
  modes().locks().clear_rest(y + mechanism_.nq);
  return closed && (contacts().located() == nullptr || close_contacts(y));
}

// Loops and contacts in turn, as the corrections of each change the others in second order.
bool Projection::close_contacts(double* y) {
  constexpr int most_turns = 4;
  ContactEquations& touched = contacts().located()->equations();
  if (touched.closed().empty()) return true;
  bool closed = true;
  for (int k = 0; k < most_turns && touched.close_position(y) && mechanism_.rows > 0; ++k)
    closed = rows_.close_position(y) && closed;
  dynamics_.set_position(y);
  touched.close_velocity(y + mechanism_.nq);
  return closed && std::isfinite(y[0]);
}

void Projection::accepted(double t, const double* y) {
  Formulation::accepted(t, y);
  if (mechanism_.cuts.empty() || mechanism_.rows == 0) return;
  if (rows_.may_become_weak()) {
    dynamics_.set_position(y);
    rows_.refactorize();
  }
  if (rows_.below(near_fraction)) return record_acceleration(t, y);
  approach_.clear();
  rows_.set_near_miss(false);
}

}  // namespace

std::unique_ptr<Formulation> make_projection(const FormulationContext& context) {
  return std::make_unique<Projection>(context);
}

}  // namespace gelenk
