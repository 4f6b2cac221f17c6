// SPDX-License-Identifier: BSD-3-Clause
// Steps of a mechanism whose prescribed motions leave it no degree of freedom: they give its positions and velocities
// at any time, so that nothing is integrated. A step extrapolates from the state where it begins,
//   q + h (v + h/2 vdot),   v + h vdot,
// and closes the constraints at its end, at the cost of one evaluation. There are as many solutions as assembly
// configurations: that of the motion is the one that a step reaches which is short compared with the distance to the
// singular configurations where they meet, and needs little correction. Near these the general method continues.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "integrator/integrator.h"

namespace gelenk {
namespace {

// The general method takes over below this distance to a singular configuration (Equations::singular_distance()).
constexpr double least_distance = 0.2;
// A step may change coordinates [rad or natural units of length] and velocities by this part of that distance and of
// the largest velocity: the distance changes by about as much as an angle of the loop.
constexpr double most_changed = 0.3;
constexpr double most_accelerated = 0.5;
// What the projection may add to an extrapolated position [rad or natural units of length], and as a fraction of its
// change: assembly configurations that come close to each other stay distinguishable.
constexpr double most_corrected = 1e-2;
constexpr double most_corrected_fraction = 0.1;
// Steps that need a tenth of that may be twice as long (their error is of third order).
constexpr double little_corrected = 0.1;
// Steps shorter than this part of the way to the end are left to the general method.
constexpr double least_fraction = 1e-4;
// Times that differ by less, as a fraction of them, are the same (event/locator.cpp).
constexpr double shortest_stretch = 1e-13;

class KinematicSteps final : public Integrator {
 public:
  KinematicSteps(Equations& system, std::unique_ptr<Integrator> general)
      : system_(system),
        general_(std::move(general)),
        nq_(system.coordinates()),
        nv_(system.velocities()),
        y_(system.size()),
        ydot_(system.size()),
        next_(system.size()),
        extrapolated_(system.size()),
        dq_(nv_) {}

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy_n(y, y_.size(), y_.begin());
  }
  double advance(double end, double* y) override { return advance_some(end, y, std::numeric_limits<long>::max()); }
  double advance_some(double end, double* y, long max_steps) override;
  void warm_up(double end, double* y) override {
    general_->restart(t_, y);
    general_->warm_up(end, next_.data());
    advance_some(end, y, 2);
  }
  void serialize(Archive& archive) override {
    Integrator::serialize(archive);
    archive.serialize(step_);
  }

 private:
  enum class Found { step, shorter_step, nothing };
  Found step(double end);
  Found shorten(double h);
  double largest_correction(int first, int end) const;
  void continue_in_general(double end);

  Equations& system_;
  std::unique_ptr<Integrator> general_;
  int nq_, nv_;
  double t_ = 0;
  std::vector<double> y_, ydot_, next_;
  std::vector<double> extrapolated_, dq_;
  double step_ = INFINITY;  // the longest that is tried [s]
  bool evaluated_ = false;  // ydot_ and distance_ are those of the present state
  double distance_ = 0;
};

double KinematicSteps::advance_some(double end, double* y, long max_steps) {
  EventSource& modes = system_.modes();
  const double shortest = least_fraction * (end - t_);
  evaluated_ = false;
  for (long made = 0; t_ < end && made < max_steps && (made == 0 || !system_.budget_exhausted()); ++made) {
    const double near = shortest_stretch * std::max(std::abs(t_), std::abs(end));
    const double ahead = modes.has_breaks() ? modes.next_break(t_ + near) : INFINITY;
    const double stop = ahead < end - near ? ahead : end;
    modes.begin_stretch(t_, ahead);
    Found found = Found::shorter_step;
    while (found == Found::shorter_step && step_ > shortest) {
      const double left = stop - t_;
      const double steps = std::ceil(left / step_ - 1e-9);
      found = step(steps <= 1 ? stop : t_ + left / steps);
    }
    modes.begin_stretch(NAN, NAN);
    if (found != Found::step) {
      continue_in_general(end);
      break;
    }
    if (t_ == stop && ahead <= end + near) modes.pass_break();
  }
  std::ranges::copy(y_, y);
  return t_;
}

// Makes a step, or sets a shorter one.
KinematicSteps::Found KinematicSteps::step(double end) {
  const double h = end - t_;
  // A shorter step from the same state needs no other evaluation, unless a projection has come between.
  if (!evaluated_ && !system_.rhs(t_, y_.data(), ydot_.data())) return Found::nothing;
  if (!evaluated_) distance_ = system_.singular_distance();
  evaluated_ = true;
  if (distance_ < least_distance) return Found::nothing;
  double change = 0;
  double speed = 0;
  for (int i = 0; i < nv_; ++i) {
    const double v = y_[nq_ + i];
    const double vdot = ydot_[nq_ + i];
    dq_[i] = h * (v + h / 2 * vdot);
    change = std::max({change, std::abs(h * v), std::abs(dq_[i])});
    next_[nq_ + i] = v + h * vdot;
    speed = std::max({speed, std::abs(v), std::abs(next_[nq_ + i])});
  }
  if (!(change <= most_changed * distance_)) return shorten(h);
  std::copy_n(y_.begin(), nq_, next_.begin());
  system_.displace(next_.data(), dq_.data());
  std::ranges::copy(next_, extrapolated_.begin());
  evaluated_ = false;
  if (!system_.project(end, next_.data()) || system_.singular_distance() == 0) return shorten(h);
  const double corrected = largest_correction(0, nq_);
  const double allowed = std::min(most_corrected, std::max(most_corrected_fraction * change, 1e-9));
  if (!(corrected <= allowed) || !(largest_correction(nq_, nq_ + nv_) <= most_accelerated * std::max(speed, 1e-9)))
    return shorten(h);
  t_ = end;
  std::swap(y_, next_);
  system_.accepted(t_, y_.data());
  ++steps_;
  if (corrected <= little_corrected * allowed) step_ = std::max(step_, 2 * h);
  return Found::step;
}

KinematicSteps::Found KinematicSteps::shorten(double h) {
  ++rejected_;
  step_ = h / 2;
  return Found::shorter_step;
}

double KinematicSteps::largest_correction(int first, int end) const {
  double out = 0;
  for (int i = first; i < end; ++i) out = std::max(out, std::abs(next_[i] - extrapolated_[i]));
  return out;
}

// Nothing of the general method remains.
void KinematicSteps::continue_in_general(double end) {
  const long steps = general_->steps();
  const long rejected = general_->rejected_steps();
  general_->restart(t_, y_.data());
  general_->begin();
  t_ = general_->advance(end, y_.data());
  steps_ += general_->steps() - steps;
  rejected_ += general_->rejected_steps() - rejected;
  step_ = INFINITY;
}

}  // namespace

std::unique_ptr<Integrator> make_kinematic_steps(Equations& system, std::unique_ptr<Integrator> general) {
  return std::make_unique<KinematicSteps>(system, std::move(general));
}

}  // namespace gelenk
