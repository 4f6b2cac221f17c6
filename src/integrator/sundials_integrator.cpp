// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/sundials_integrator.h"

#include <algorithm>
#include <climits>
#include <cmath>

namespace gelenk {

SundialsIntegrator::SundialsIntegrator(Equations& system) : system_(system), n_(system.size()), y_(new_vector()) {}

N_Vector SundialsIntegrator::new_vector() {
  N_Vector v =
      sundials::made(N_VNew_Serial(std::max(1, system_.unknowns()), context_));  // a scene may have nothing that moves
  N_VConst(0, v);
  return v;
}

void SundialsIntegrator::restart(double t, const double* y) {
  t_ = t;
  std::copy(y, y + n_, sundials::data(y_.get()));
  fresh_ = true;
}

void SundialsIntegrator::keep_counts() {
  kept_steps_ = steps_;
  kept_rejected_ = rejected_;
}

void SundialsIntegrator::add_kept_counts() {
  steps_ += kept_steps_;
  rejected_ += kept_rejected_;
}

void SundialsIntegrator::advance(double end, double* y) {
  patience_end_ = -INFINITY;
  advance_by(end, y, LONG_MAX);
}

double SundialsIntegrator::advance_some(double end, double* y, long most) {
  advance_by(end, y, most);
  return t_;
}

void SundialsIntegrator::advance_by(double end, double* y, long most) {
  const double start = t_;
  if (end != patience_end_) {
    patience_ = Patience(start, end);
    patience_end_ = end;
  }
  prepare(end);
  for (; t_ < end && most > 0; --most) {
    Step step = make_step(end);
    if (step != Step::made && jumped_ && t_ == start) {
      // A history that cannot be carried across the jump.
      restart(start, y);
      prepare(end);
      step = make_step(end);
    }
    jumped_ = false;
    if (step != Step::made) fail(step, start);
    system_.accepted(t_, sundials::data(y_.get()));
    patience_.step_to(t_);
  }
  count();
  std::copy(sundials::data(y_.get()), sundials::data(y_.get()) + n_, y);
}

int SundialsIntegrator::rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self) {
  return static_cast<SundialsIntegrator*>(self)->system_.rhs(t, sundials::data(y), sundials::data(ydot)) ? 0 : 1;
}

int SundialsIntegrator::jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector,
                                 N_Vector) {
  Equations& system = static_cast<SundialsIntegrator*>(self)->system_;
  return system.jacobian(t, sundials::data(y), SUNDenseMatrix_Data(J)) ? 0 : 1;
}

void SundialsIntegrator::fail(Step step, double start) {
  const double t = reached();
  const std::string where = at_time(std::isfinite(t) ? t : start);
  const std::string obstacle = system_.obstacle(sundials::data(y_.get()));
  if (!obstacle.empty()) throw IntegrationError(where + obstacle);
  switch (step) {
    case Step::too_small:
      throw IntegrationError(where + "no step is small enough for the tolerance");
    case Step::not_finite:
      throw IntegrationError(where + "the accelerations are not finite");
    case Step::not_closed:
      throw IntegrationError(where + "the loops could not be closed again");
    default:
      throw IntegrationError(where + "the integrator stopped (" + context_.last_error() + ")");
  }
}

}  // namespace gelenk
