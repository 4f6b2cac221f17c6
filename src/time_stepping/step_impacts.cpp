// SPDX-License-Identifier: BSD-3-Clause
// Impacts within steps of TimeStepper: the laws of restitution, for all that is struck together.
#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/loads.h"
#include "time_stepping/step_limits.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {
namespace {

// What is struck within this part of a step after another is struck together with it: far more than the errors of the
// positions of bodies that arrive at the same instant; and what is nearer than the fastest of them moves in that time,
// as at the corner of a box that rests while others land.
constexpr double together = 0.01;
// The energy that an impact may gain by what is left of the velocities, relative to what it exchanges.
constexpr double energy_rounding = 1e-9;
// What approaches faster than gravity makes it in this number of steps strikes; what is slower is pressed.
constexpr double steps_of_fall = 4;
// Of the part of the restitution that adds no energy.
constexpr int most_bisections = 20;

int end_of(const Cone& cone) { return cone.first + cone.size(); }

void set_part_of(std::span<const std::pair<int, int>> part, const std::vector<Cone>& cones, double of,
                 Restitution& to) {
  to.set_part(of, [&](int row) {
    return std::ranges::any_of(part, [&](const std::pair<int, int>& at) { return cones[at.second].first == row; });
  });
}

// Whether a limit may throw a joint back that a one-way clutch permits no motion back. points: cones before those of
// joints.
bool has_clutch(std::span<const std::pair<int, int>> part, std::size_t points, const JointRows& joints) {
  return std::ranges::any_of(part, [&](const std::pair<int, int>& at) {
    const auto cone = static_cast<std::size_t>(at.second);
    return cone >= points && joints[cone - points].is_of_speed;
  });
}

// The energy of impulses.
struct Exchange {
  double gained = 0, exchanged = 0;

  void add(double impulse, double before, double after) {
    gained += impulse * (before + after) / 2;
    exchanged += std::abs(impulse) * (std::abs(before) + std::abs(after));
  }
  // Without what is rounding.
  double energy() const { return gained > energy_rounding * exchanged ? gained : 0; }
};

}  // namespace

// The law of the restitution with which it is struck.
Restitution::Struck TimeStepper::restitution_of(std::size_t cone) const {
  Restitution::Struck out{.row = cones_[cone].first, .approach = approach(cone)};
  if (cone < points_.size()) {
    out.restitution = loads_.contacts[static_cast<std::size_t>(points_[cone].contact)].restitution;
  } else if (const JointRows::Row& row = joints_[cone - points_.size()]; row.side != 0) {
    out.sign = -row.side;
    const SwitchingForces& forces = dynamics_.switching_forces();
    out.restitution = forces.depth(row.lock, row.side).restitution;
    out.poisson = forces.lock(row.lock).poisson;
  }
  return out;
}

// The speed at which the gap of a cone closes at the start of the step; 0: it does not.
double TimeStepper::approach(std::size_t cone) const {
  return std::max(-gap_of(cone).sign * speeds_[static_cast<std::size_t>(cones_[cone].first)], 0.0);
}

// Where something with restitution or friction strikes within the step, all that is struck in it is struck at once. If
// it were only braked so that it closes its gap at the end of the step, and stopped in the next one, friction would act
// on two parts of the impulse, which is not the same as on the whole one, and depends on when in the step it strikes;
// and friction of joints that depends on loads would take the impulse for a load. By Poisson's law even what rests may
// throw back what strikes another. A latch that is engaged in motion strikes, too.
void TimeStepper::find_strikes(double h) {
  strikes_.assign(cones_.size(), 0);
  has_compression_ = false;
  strikes_any_ = joints_.find_engaged(v0_.data(), velocity_tolerance(), strikes_.data() + points_.size());
  const auto reaches = [&](std::size_t i, double time) {
    return gap_of(i).sign != 0 && gap_of(i).gap - time * approach(i) <= touch_tolerance;
  };
  const double fall = steps_of_fall * h * loads_.gravity.norm();
  bool any_poisson = false;
  for (std::size_t i = points_.size(); i < cones_.size(); ++i) {
    const Restitution::Struck at = restitution_of(i);
    any_poisson = any_poisson || (at.poisson && at.restitution > 0);
  }
  for (std::size_t i = 0; i < cones_.size() && !strikes_any_; ++i) {
    const Restitution::Struck at = restitution_of(i);
    const double least = at.restitution > 0 ? rest_speed : std::max(rest_speed, fall);
    const bool strikes = at.restitution > 0 || cones_[i].size() > 1 || any_poisson || joints_.have_loads();
    strikes_any_ = strikes && at.approach > least && reaches(i, h / 2);
  }
  if (!strikes_any_) return;
  double fastest = 0;
  for (std::size_t i = 0; i < cones_.size(); ++i) fastest = std::max(fastest, reaches(i, h / 2) ? approach(i) : 0);
  const auto is_near = [&](std::size_t i) { return gap_of(i).sign != 0 && gap_of(i).gap <= together * h * fastest; };
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    if (reaches(i, (0.5 + together) * h) || is_near(i)) strikes_[i] = 1;
    if (strikes_[i] != 0) restitution_.add(restitution_of(i));
  }
  if (restitution_.needs_compression()) find_compression();
}

// Whether it was struck without restitution and does not leave, at the speeds free_speeds_ after the step.
bool TimeStepper::remains_struck(std::size_t cone) const {
  const auto r = static_cast<std::size_t>(cones_[cone].first);
  return strikes_[cone] != 0 && restitution_of(cone).restitution == 0 && x_[r] != 0 &&
         std::abs(free_speeds_[r]) <= rest_speed;
}

// The impulses that end all approaches, without those of other forces. Latches and one-way clutches take part, as in
// expansion: what they do not let give way returns what strikes it. Friction of joints exerts none.
void TimeStepper::find_compression() {
  has_compression_ = true;
  compression_cones_.clear();
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const JointRows::Row* const joint = i < points_.size() ? nullptr : &joints_[i - points_.size()];
    if (strikes_[i] != 0 || (joint != nullptr && (joint->is_of_speed || joint->is_latch))) {
      compression_cones_.push_back(cones_[i]);
      continue;
    }
    for (int k = 0; k < cones_[i].size(); ++k) compression_cones_.push_back(Cone::within(cones_[i].first + k, 0, 0));
  }
  for (std::size_t r = 0; r < b_.size(); ++r) b_[r] = speeds_[r] + belts_[r];
  free_speeds_ = b_;
  std::ranges::fill(compression_, 0.0);
  solve(compression_cones_, compression_);
}

// That the impulses of contacts, limits and latches of a part add, between the velocities before and after them.
double TimeStepper::gained_energy(std::span<const std::pair<int, int>> part) {
  rows_.apply(x_.data(), after_.data());
  Exchange exchange;
  for (const auto& [of, number] : part) {
    const auto i = static_cast<std::size_t>(number);
    if (i < points_.size() ? cones_[i].is_ball : joints_[i - points_.size()].is_friction()) continue;
    for (auto r = static_cast<std::size_t>(cones_[i].first); r < static_cast<std::size_t>(end_of(cones_[i])); ++r)
      exchange.add(x_[r], speeds_[r] + belts_[r], free_speeds_[r] + after_[r]);
  }
  return exchange.energy();
}

// Where the laws would add energy, as where unlike restitutions are struck together, restitution is reduced, of what
// acts on each other; where they exclude each other, as beside a one-way clutch, impacts are inelastic.
void TimeStepper::reduce_restitution(double h) {
  const auto solve_again = [&] {
    set_velocities(h);
    solve_impulses();
  };
  parts_.divide({operator_, b_, cones_, true});
  if (joints_.any_of_speed() && misses(last_residual_)) {
    std::ranges::fill(x_, 0.0);
    each_part_of(parts_.by_part(), [&](std::span<const std::pair<int, int>> part) {
      if (has_clutch(part, points_.size(), joints_)) set_part_of(part, cones_, 0, restitution_);
    });
    solve_again();
  }
  each_part_of(parts_.by_part(), [&](std::span<const std::pair<int, int>> part) {
    if (gained_energy(part) <= 0) return;
    const auto adds_none = [&](double of) {
      set_part_of(part, cones_, of, restitution_);
      solve_again();
      return gained_energy(part) <= 0;
    };
    adds_none(largest_part(most_bisections, adds_none));
  });
}

}  // namespace gelenk
