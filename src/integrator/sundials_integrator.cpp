// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/sundials_integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Nearer to an end of the step than this part of it, a kink does no harm.
constexpr double switch_share = 1e-9;
// Likewise where the rate is not known, so that a straight line has to do; the force itself has no jump there.
constexpr double corner_share = 1e-3;

}  // namespace

double bdf_tolerance(double share, double tolerance, bool dae) {
  return share * tolerance * (dae ? 1 : std::pow(std::min(1.0, tolerance / 1e-4), 0.2));
}

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

void SundialsIntegrator::exchange(Record& record) {
  Integrator::exchange(record);
  record.exchange(jumped_);
  keep_counts();
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

double SundialsIntegrator::advance(double end, double* y) {
  patience_end_ = t_;  // no advance ends where it begins
  return advance_some(end, y, std::numeric_limits<long>::max());
}

void SundialsIntegrator::keep_start() {
  const double* y = sundials::data(y_.get());
  start_t_ = t_;
  start_y_.assign(y, y + n_);
  for (auto* values : {&start_g_, &start_gdot_, &g_, &gdot_}) values->resize(system_.switches());
  system_.switch_values(y, start_g_.data(), start_gdot_.data());
}

// s: the first zero of a switch inside the step just made, by the cubic through values and rates at both ends; t_ if
// there is none. The cubic is rough where the kink is inside, but the next one ends near it.
double SundialsIntegrator::first_switch() {
  system_.switch_values(sundials::data(y_.get()), g_.data(), gdot_.data());
  const double h = t_ - start_t_;
  double first = 1;
  double share = switch_share;
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if ((start_g_[i] < 0) == (g_[i] < 0)) continue;
    const bool smooth = std::isfinite(start_gdot_[i]) && std::isfinite(gdot_[i]);
    const auto value = [&](double s) {
      const double r = 1 - s;
      if (!smooth) return r * start_g_[i] + s * g_[i];
      return r * r * (1 + 2 * s) * start_g_[i] + s * s * (3 - 2 * s) * g_[i] +
             s * r * h * (r * start_gdot_[i] - s * gdot_[i]);
    };
    double low = 0;
    double high = 1;
    for (int k = 0; k < 50; ++k) {
      const double middle = (low + high) / 2;
      ((value(middle) < 0) == (start_g_[i] < 0) ? low : high) = middle;
    }
    if (high >= first) continue;
    first = high;
    share = smooth ? switch_share : corner_share;
  }
  const double at = start_t_ + first * h;
  const double nearest = std::max(share * h, 1e-15 * std::abs(t_));  // as near as times can be told apart
  return at > start_t_ + nearest && at < t_ - nearest ? at : t_;
}

double SundialsIntegrator::advance_some(double end, double* y, long most) {
  system_.polish(takes_differences());
  const double start = t_;
  if (end != patience_end_) {
    patience_ = Patience(start, end);
    patience_end_ = end;
  }
  const bool watched = steps_back() && system_.switches() > 0;
  double target = end;
  prepare(target);
  for (; t_ < end && most > 0; --most) {
    if (t_ >= target) prepare(target = end);
    if (watched) keep_start();
    Step step = make_step(target);
    if (step != Step::made && jumped_ && t_ == start) {
      // A history that cannot be carried across the jump.
      restart(start, y);
      prepare(target);
      step = make_step(target);
    }
    jumped_ = false;
    if (step != Step::made) fail(step, start);
    const double at = watched ? first_switch() : t_;
    const bool back = at < t_;
    if (back) {
      restart(start_t_, start_y_.data());
      prepare(target = at);
    } else {
      system_.accepted(t_, sundials::data(y_.get()));
    }
    if (const std::string why = patience_.step_to(t_); !why.empty()) {
      refuse(system_, t_, sundials::data(y_.get()), why);
    }
    if (!back && system_.spent()) break;
  }
  count();
  std::copy(sundials::data(y_.get()), sundials::data(y_.get()) + n_, y);
  return t_;
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
  std::string why;
  switch (step) {
    case Step::too_small:
      why = "no step is small enough for the tolerance";
      break;
    case Step::not_finite:
      why = "the accelerations are not finite";
      break;
    case Step::not_closed:
      why = "the loops could not be closed again";
      break;
    default:
      why = "the integrator stopped (" + context_.last_error() + ")";
  }
  refuse(system_, std::isfinite(t) ? t : start, sundials::data(y_.get()), why);
}

}  // namespace gelenk
