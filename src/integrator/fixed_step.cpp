// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/fixed_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// So many successive steps within this part of a step of the grid lead nowhere; a series of impacts ends earlier.
constexpr int most_stuck = 2000;
constexpr double resolved_fraction = 1e-9;

}  // namespace

FixedStep::FixedStep(Equations& system, const IntegratorOptions& options)
    : system_(system), n_(system.size()), y_(n_), k_(n_), locator_(system.modes(), n_), step_(options.step) {}

void FixedStep::restart(double t, const double* y) {
  t_ = t;
  std::copy(y, y + n_, y_.begin());
  locator_.restart();
  if (locates_events()) system_.modes().keep_directions_below(no_direction);
}

void FixedStep::serialize(Archive& archive) {
  Integrator::serialize(archive);
  locator_.serialize(archive);
}

double FixedStep::advance(double end, double* y) { return advance_some(end, y, std::numeric_limits<long>::max()); }

double FixedStep::advance_some(double end, double* y, long max_steps) {
  // Equal steps, as many as needed so that none is longer than the step size. Times are rounded, more coarsely the
  // later they are: if whole steps fit within that, all have the given size, so that the same grid gives the same bits
  // however it is divided into communication steps.
  const double start = t_;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  const double span = end - start;
  const double needed = std::clamp(std::ceil((span - rounding) / step_ - 1e-9), 1.0, 1e15);
  const long count = static_cast<long>(needed);
  const double whole = needed * step_;
  const bool fits = std::abs(whole - span) <= rounding + 1e-12 * span;
  const double h = fits ? step_ : span / needed;
  for (long i = 0; i < std::min(count, max_steps) && (i == 0 || !system_.budget_exhausted()); ++i) {
    const double next = i + 1 == count ? end : start + static_cast<double>(i + 1) * h;
    if (locates_events() && locator_.is_needed()) {
      step_by_events(next);
    } else {
      take_step(start + static_cast<double>(i) * h, h, next);
      system_.accepted(t_, y_.data());
      ++steps_;
    }
  }
  std::ranges::copy(y_, y);
  return t_;
}

void FixedStep::take_step(double t, double h, double end) {
  make_step(t, h);
  t_ = end;
  if (!system_.project(t_, y_.data())) refuse(system_, t_, y_.data(), "constraint projection did not converge");
}

// One step of the grid, divided at events.
void FixedStep::step_by_events(double end) {
  int stuck = 0;
  while (t_ < end) {
    const double before = t_;
    const Step step = locator_.step(*this, end);
    if (step == Step::refused) throw RefusedMotion(at_time(t_) + system_.modes().refusal());
    if (step != Step::made) throw IntegrationError(error_);
    system_.accepted(t_, y_.data());
    ++steps_;
    stuck = t_ - before > resolved_fraction * step_ ? 0 : stuck + 1;
    if (stuck > most_stuck) {
      throw IntegrationError(at_time(t_) +
                             "friction, limits or laws change their modes again and again: no motion agrees "
                             "with all of them, as where a law jumps to drive back what friction holds");
    }
  }
}

Step FixedStep::step_towards(double end) {
  try {
    take_step(t_, end - t_, end);
  } catch (const IntegrationError& error) {
    error_ = error.what();
    return Step::not_closed;
  }
  return Step::made;
}

void FixedStep::evaluate(double t, const double* y) {
  if (!system_.rhs(t, y, k_.data())) refuse(system_, t, y, "the accelerations are not finite");
}

}  // namespace gelenk
