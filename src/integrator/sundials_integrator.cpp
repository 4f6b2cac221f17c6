// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/sundials_integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Speeds of sliding, in units of the tolerance, from which the control of errors follows the direction of friction: an
// error of one tolerance then turns it by a hundredth.
constexpr double followed_tolerances = 100;

}  // namespace

EventSource::SlowSliding slow_sliding(double tolerance, bool is_explicit) {
  return {.followed_from = followed_tolerances * tolerance, .is_explicit = is_explicit};
}

double bdf_tolerance(double fraction, double tolerance) {
  return fraction * tolerance * std::pow(std::min(1.0, tolerance / 1e-4), 0.2);
}

double inverse_bdf_tolerance(double fraction, double error) {
  const double whole = error / fraction;
  return whole > 1e-4 ? whole : 1e-4 * std::pow(whole / 1e-4, 1 / 1.2);
}

N_Vector sundials::new_vector(const Equations& system, SUNContext context) {
  N_Vector v = made(N_VNew_Serial(std::max(1, system.unknowns()), context));  // a scene may have no moving bodies
  N_VConst(0, v);
  return v;
}

SundialsIntegrator::SundialsIntegrator(Equations& system, const EventSource::SlowSliding& slow_sliding,
                                       bool takes_differences)
    : system_(system),
      y_(sundials::new_vector(system, context_)),
      locator_(system.modes(), system.size()),
      slow_sliding_(slow_sliding),
      takes_differences_(takes_differences) {}

void SundialsIntegrator::continue_from(double t, const double* y) {
  t_ = t;
  std::copy(y, y + system_.size(), sundials::data(y_.get()));
  fresh_ = true;
  resumed_ = false;
  failed_ = Step::made;
  stall_.clear();
  locator_.restart();
}

void SundialsIntegrator::serialize(Archive& archive) {
  Integrator::serialize(archive);
  archive.serialize(jumped_);
  locator_.serialize(archive);
  if (!archive.reading()) return;
  keep_counts();
  fresh_ = true;
  stalls_.reset();
}

void SundialsIntegrator::add_counts() {
  if (fresh_) return;
  const Counts made = count();
  steps_ = base_counts_.steps + made.steps;
  rejected_ = base_counts_.rejected + made.rejected;
}

void SundialsIntegrator::keep_counts() { base_counts_ = {steps_, rejected_}; }

double SundialsIntegrator::advance(double end, double* y) {
  do {
    advance_some(end, y, std::numeric_limits<long>::max());
  } while (t_ < end && !system_.budget_exhausted());
  return t_;
}

double SundialsIntegrator::advance_some(double end, double* y, long max_steps) {
  system_.polish(takes_differences_);
  const double start = t_;
  if (!stalls_) stalls_.emplace(start, end);
  const bool locates = locator_.is_needed() && !passes_events_;
  // In a very short step multipliers would be rounding only.
  const bool across = system_.multipliers() > 0;
  const auto step_towards = [&] {
    if (!locates) {
      before_step();
      return make_limited_step(end);
    }
    return across ? locator_.step_across(*this, end) : locator_.step(*this, end);
  };
  if (failed_ != Step::made) fail(failed_, start);
  if (!stall_.empty()) refuse(system_, t_, sundials::data(y_.get()), stall_);
  prepare(stop_time_ = end);
  for (; t_ < end && max_steps > 0; --max_steps) {
    Step step = step_towards();
    if (step != Step::made && jumped_ && t_ == start) {
      // The history cannot be continued across the jump.
      restart(start, y);
      prepare(stop_time_ = end);
      step = step_towards();
    }
    jumped_ = false;
    // Modes have changed at events on the way, so that another method cannot begin again at the start: what has been
    // reached is kept, and the next call fails here.
    if (step != Step::made && (t_ == start || !locates)) fail(step, start);
    failed_ = step;
    if (step != Step::made) break;
    system_.accepted(t_, sundials::data(y_.get()));
    stall_ = stalls_->step_to(t_);
    if (!stall_.empty() && !locates) refuse(system_, t_, sundials::data(y_.get()), stall_);
    if (!stall_.empty() || system_.budget_exhausted()) break;
  }
  add_counts();
  std::copy_n(sundials::data(y_.get()), system_.size(), y);
  return t_;
}

Step SundialsIntegrator::make_limited_step(double end) {
  const double allowed = system_.end_of_step(t_);
  if (!(allowed < std::min(end, stop_time_))) return make_step(end);
  set_stop_time(allowed);
  const Step step = make_step(end);
  set_stop_time(stop_time_);
  return step;
}

int sundials::rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* integrator) {
  return static_cast<SundialsIntegrator*>(integrator)->system().rhs(t, data(y), data(ydot)) ? 0 : 1;
}

int sundials::jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* integrator, N_Vector, N_Vector,
                       N_Vector) {
  Equations& system = static_cast<SundialsIntegrator*>(integrator)->system();
  return system.jacobian(t, data(y), SUNDenseMatrix_Data(J)) ? 0 : 1;
}

void SundialsIntegrator::fail(Step step, double start) {
  if (step == Step::refused) throw RefusedMotion(at_time(t_) + system_.modes().refusal());
  const double t = reached();
  std::string why;
  switch (step) {
    case Step::too_small:
      why = "the tolerance cannot be met even with the smallest step size";
      break;
    case Step::not_finite:
      why = "the accelerations are not finite";
      break;
    case Step::not_closed:
      why = "constraint projection did not converge";
      break;
    default:
      why = "the integrator stopped (" + context_.last_error() + ")";
  }
  refuse(system_, std::isfinite(t) ? t : start, sundials::data(y_.get()), why);
}

}  // namespace gelenk
