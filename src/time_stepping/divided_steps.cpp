// SPDX-License-Identifier: BSD-3-Clause
// Steps of TimeStepper, which are divided where the velocities do not converge.
#include <algorithm>
#include <cmath>

#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

// Forces that depend on velocities, those of fast rotation among them, are evaluated twice. If the second evaluation
// changes the velocities by more than the first part, it is repeated until one changes them by no more than the second:
// as long as they do not converge, fast rotations of mechanisms gain or lose energy.
constexpr double notable = 1e-3;
constexpr double settled = 1e-6;
constexpr int most_repetitions = 8;
// The last change may be this part of the one before, beyond which repetition would not converge quickly; it does not
// count up to this part of the velocities.
constexpr double quick = 0.5;
constexpr double negligible = 0.05;
// Angle by which a body may turn freely in a step [rad], unless it cannot be divided further.
constexpr double most_turned_at_first = 1;
constexpr double most_turned_at_last = 2;
constexpr const char* too_fast =
    "the velocities do not converge, expected a smaller solver.step for motions as fast as these";

// Repeated evaluations of the forces in a step.
struct Repetitions {
  bool last = false;  // poor convergence suffices
  double change = 0;  // of the velocities by the last one
  int count = 0;
  bool converge = true;
  bool damped = false;  // the mean of two solutions is used, as they follow each other in turn

  // After one that has changed the velocities by `by`. enough, little: changes that end them, that do not count.
  bool need_another(double by, double enough, double little) {
    const double before = change;
    change = by;
    ++count;
    if (by <= enough) {
      converge = true;
      return false;
    }
    if (count == 1) return true;
    // Where impulses jump from one solution to another, later ones may come no closer to each other.
    if (count > 2 && !damped) return by <= quick * before;
    converge = by <= std::max(quick * before, little) || (last && by <= before);
    if (converge ? damped : !last) return false;
    damped = !converge;
    return true;
  }
};

bool all_finite(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
}

}  // namespace

// Divides a step whose forces do not converge into halves.
bool TimeStepper::step_in_parts(double h, const double* u, double* y, int halvings) {
  std::vector<double>& start = starts_[static_cast<std::size_t>(halvings)];
  std::copy_n(y, start.size(), start.data());
  const Solved before = solved_;
  const bool last = halvings == most_halvings;
  if (attempt(h, u, y, last)) {
    failure_ = "";
    return true;
  }
  if (last) return false;
  std::ranges::copy(start, y);
  solved_.residual = before.residual;
  return step_in_parts(h / 2, u, y, halvings + 1) && step_in_parts(h / 2, u, y, halvings + 1);
}

// The largest change of the velocities from the solution before to this one.
double TimeStepper::change() const {
  double out = 0;
  for (std::size_t k = 0; k < v0_.size(); ++k) out = std::max(out, std::abs(v1_[k] - (2 * vm_[k] - v0_[k])));
  return out;
}

// Changes up to this part of the velocities do not count.
double TimeStepper::small_change(double part) const {
  double out = rest_speed;
  for (std::size_t k = 0; k < v0_.size(); ++k) out = std::max({out, part * std::abs(v0_[k]), part * std::abs(v1_[k])});
  return out;
}

// Returns false, with y and the forces of contacts as they were or not to be used, unless the velocities converge.
// last: poor convergence suffices.
bool TimeStepper::attempt(double h, const double* u, double* y, bool last) {
  double* v = y + mechanism_.nq;
  std::copy_n(v, v0_.size(), v0_.data());
  for (std::size_t k = 0; k < v0_.size(); ++k) dq_[k] = h / 2 * v0_[k];
  rotation_.set_first_half(h, v0_.data(), dq_.data());
  dynamics_.displace(y, dq_.data());
  dynamics_.set_position(y);
  dynamics_.factorize();
  dynamics_.readings().set_root_poses();
  dynamics_.set_velocity(v0_.data());
  if (dynamics_.switching_forces().locks() > 0) dynamics_.solve(u, vdot_.data());
  collect(h);
  if (joints_.are_undefined()) return false;
  vm_ = v0_;
  if (!converge(h, u, last)) return false;
  add_passed_limits(h);
  for (std::size_t k = 0; k < v1_.size(); ++k) dq_[k] = h / 2 * v1_[k];
  rotation_.set_rest(h, v0_.data(), v1_.data(), dynamics_.readings(), dq_.data());
  correct_position(h, dq_.data());
  dynamics_.displace(y, dq_.data());
  std::ranges::copy(v1_, v);
  remember(h);
  return all_finite(v1_) && all_finite(dq_);
}

// v1_ <- the velocities at the end of the step, after the position in the middle has been set.
bool TimeStepper::converge(double h, const double* u, bool last) {
  const double largest = solved_.residual;
  failure_ = "the velocities are not finite";
  const double most_turned = last ? most_turned_at_last : most_turned_at_first;
  using Holding = LoadIteration::Holding;
  if (update_forces(h, u, most_turned) == Forces::too_fast || !respond(h, u, Holding::by_any_force)) return false;
  // Once more, with forces at the mean velocity that was found, and again where that changes the velocities notably.
  Repetitions done{last, change()};
  while (done.count < most_repetitions) {
    for (std::size_t k = 0; k < v0_.size(); ++k) {
      const double mean = (v0_[k] + v1_[k]) / 2;
      vm_[k] = done.damped ? (vm_[k] + mean) / 2 : mean;
    }
    const Forces forces = update_forces(h, u, most_turned);
    if (forces == Forces::too_fast) return false;
    const bool turns = stop_turning_points(h);
    const bool slides = joints_.set_sliding_friction(h, v1_.data(), vm_.data(), x_.data(), joint_cones());
    if (!slides && !turns && forces == Forces::as_before) break;
    solved_.residual = largest;  // of the results that count
    if (!respond(h, u, Holding::as_guessed)) return false;
    const double enough = small_change(done.count == 0 ? notable : settled);
    if (!done.need_another(change(), enough, small_change(negligible))) break;
  }
  if (!done.converge) failure_ = too_fast;
  return done.converge;
}

// vdot_ <- the accelerations by the forces at vm_, and whether they have changed, by more than what the solver leaves
// of velocities: the forces on spheres, for example, do not depend on their velocities.
TimeStepper::Forces TimeStepper::update_forces(double h, const double* u, double most_turned) {
  vdot_before_ = vdot_;
  dynamics_.set_velocity(vm_.data());
  dynamics_.solve(u, vdot_.data());
  if (!all_finite(vdot_)) return Forces::changed;  // respond() says so
  if (!rotation_.balance(h, v0_.data(), vm_.data(), most_turned, dynamics_.readings(), vdot_.data())) {
    failure_ = too_fast;
    return Forces::too_fast;
  }
  double change = 0, fastest = residual_floor;
  for (std::size_t k = 0; k < v1_.size(); ++k) {
    change = std::max(change, h * std::abs(vdot_[k] - vdot_before_[k]));
    fastest = std::max(fastest, std::abs(v1_[k]));
  }
  return change > negligible_change * fastest ? Forces::changed : Forces::as_before;
}

// v1_ <- the velocities at the end of the step, with the accelerations vdot_ of smooth forces. holding: of friction
// that depends on loads.
bool TimeStepper::respond(double h, const double* u, LoadIteration::Holding holding) {
  return joints_.have_loads() ? settle_loads(h, u, holding) : respond_to_smooth_forces(h);
}

// The same with the limits of friction as they are set. Returns false where smooth forces are not finite.
bool TimeStepper::respond_to_smooth_forces(double h) {
  for (std::size_t k = 0; k < v1_.size(); ++k) v1_[k] = v0_[k] + h * vdot_[k];
  if (!all_finite(v1_)) return false;
  if (cones_.empty()) return true;
  restitution_.set_part(1);
  set_velocities(h);
  solve_impulses();
  if (strikes_any_) reduce_restitution(h);
  rows_.strike(x_.data(), v1_.data());
  return true;
}

}  // namespace gelenk
