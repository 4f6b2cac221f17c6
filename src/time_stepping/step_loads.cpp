// SPDX-License-Identifier: BSD-3-Clause
// Friction of joints that depends on the forces of bearings, guides and gears, which depend on it, in steps of
// TimeStepper: a fixed point of its limits, which those forces determine as they act with it, on average over the step.
#include <algorithm>

#include "time_stepping/load_iteration.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

constexpr const char* undetermined_loads =
    "the friction of a joint depends so much on the load of its bearing, guide or gear that no motion, or more than "
    "one, agrees with it";

}  // namespace

// The limits of friction that follow from the forces of a step with given ones.
class TimeStepper::LoadedStep final : public LoadIteration::Friction {
 public:
  LoadedStep(TimeStepper& of, double h, const double* u) : of_(of), h_(h), u_(u) {}
  bool respond(const std::vector<double>& limits, std::vector<double>& found) override {
    of_.joints_.set_limits(h_, limits.data(), of_.joint_cones());
    if (!of_.respond_to_smooth_forces(h_)) return false;
    of_.apply_mean_forces(h_, u_);
    of_.joints_.find_limits(of_.vm_.data(), found);
    return true;
  }
  void add_reached(std::vector<int>& out) const override {
    of_.joints_.add_reached_limits(of_.x_.data(), of_.joint_cones(), out);
  }
  bool stops() const override { return of_.joints_.any_stops(of_.v1_.data()); }

 private:
  TimeStepper& of_;
  double h_;
  const double* u_;
};

// Solves the equations of motion with the mean impulses x_ of the step as forces, which brings loads to them. Impulses
// of impacts are left out: friction of joints exerts none in return.
void TimeStepper::apply_mean_forces(double h, const double* u) {
  std::ranges::fill(load_along_, 0.0);
  load_x_ = x_;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    if (strikes_[i] == 0) continue;
    std::fill_n(load_x_.begin() + cones_[i].first, cones_[i].size(), 0.0);
  }
  rows_.add_generalized(static_cast<int>(x_.size()) - static_cast<int>(joints_.count()), load_x_.data(), 1 / h,
                        load_along_.data());
  const bool has_shapes = mechanism_.touches();
  if (has_shapes) {
    std::ranges::fill(load_wrenches_, Spatial::Force{});
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (strikes_[i] == 0) add_wrench(points_[i], force_at(i, h), load_wrenches_);
    }
  }
  rows_.apply_forces(has_shapes ? load_wrenches_.data() : nullptr, load_along_.data());
  dynamics_.solve(u, load_vdot_.data());
  rows_.apply_forces(nullptr, nullptr);
}

// v1_ <- the velocities at the end of the step with the friction that follows from its forces.
bool TimeStepper::settle_loads(double h, const double* u, LoadIteration::Holding holding) {
  load_along_.resize(v0_.size());
  load_vdot_.resize(v0_.size());
  load_wrenches_.resize(mechanism_.links.size());
  joints_.read_limits(limits_, limit_kinds_);
  LoadedStep step(*this, h, u);
  if (strikes_any_) holding = LoadIteration::Holding::in_impact;
  if (loads_iteration_.settle(step, limit_kinds_, holding, limits_)) return true;
  failure_ = undetermined_loads;
  return false;
}

}  // namespace gelenk
