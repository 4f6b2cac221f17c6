// SPDX-License-Identifier: BSD-3-Clause
// Steps end where the equations have a kink, at a zero of one of the system's switches. Until there the step keeps to
// the branch on which it began, so that it is as smooth as the method wants it; where the switch is zero is found by
// making the step again, to other ends.
#include <algorithm>
#include <cmath>
#include <limits>

#include "integrator/sundials_integrator.h"
#include "math/bracket.h"

namespace gelenk {
namespace {

// Of the step. A force that jumps acts so much too long or too short, beside what it does in the step less than any
// tolerance.
constexpr double nearest_share = 1e-13;
// s, as near as times can be told apart.
double rounding(double t) { return 4 * std::numeric_limits<double>::epsilon() * std::abs(t); }
// Of steps made again; halving alone takes 44.
constexpr int most_trials = 60;
// Steps made shorter in search of a touch that begins and ends within one.
constexpr int most_strays = 20;

// While it lives the system keeps to a branch.
class Held {
 public:
  Held(Equations& system, double t, const bool* on) : system_(system) { system_.hold_switches(t, on); }
  ~Held() { system_.hold_switches(0, nullptr); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  Equations& system_;
};

}  // namespace

void SundialsIntegrator::read_switches(std::vector<double>& g, std::vector<double>& gdot, bool* on) const {
  system_.switch_values(sundials::data(y_.get()), g.data(), gdot.data());
  for (std::size_t i = 0; i < g.size(); ++i) on[i] = g[i] > 0 || (g[i] == 0 && gdot[i] >= 0);
}

void SundialsIntegrator::keep_start() {
  const std::size_t switches = system_.switches();
  if (!on_) {
    for (auto* values : {&start_g_, &start_gdot_, &g_, &gdot_}) values->resize(switches);
    start_on_ = std::make_unique<bool[]>(switches);
    on_ = std::make_unique<bool[]>(switches);
    high_y_.resize(n_);
  }
  const double* y = sundials::data(y_.get());
  start_t_ = t_;
  start_y_.assign(y, y + n_);
  read_switches(start_g_, start_gdot_, start_on_.get());
}

void SundialsIntegrator::keep_high() {
  high_t_ = t_;
  std::copy_n(sundials::data(y_.get()), n_, high_y_.begin());
}

SundialsIntegrator::Step SundialsIntegrator::step_to_switch(double end) {
  keep_start();
  const Held held(system_, start_t_, start_on_.get());
  Step step = make_step(end);
  // A branch may lead to where loops cannot be closed; the run leaves it before.
  for (int k = 0; k < most_strays && step == Step::not_closed && strayed_inside(end); ++k) {
    step = step_from_start(system_.strayed());
    begin(end);
  }
  if (step != Step::made) return step;
  read_switches(g_, gdot_, on_.get());
  const auto any = [&] { return !std::equal(on_.get(), on_.get() + g_.size(), start_on_.get()); };
  for (int k = 0; k < most_strays && !any(); ++k) {
    if (!strayed_inside(t_)) return step;
    step = step_from_start(system_.strayed());
    begin(end);
    if (step != Step::made) return step;
  }
  if (!any()) return step;
  keep_high();
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (!crossed(i)) continue;
    step = search(i, end);
    if (step != Step::made || t_ != high_t_) return step;
  }
  return step;
}

// Whether the step has asked for f beyond a switch, before `end`.
bool SundialsIntegrator::strayed_inside(double end) const {
  const double strayed = system_.strayed();
  return strayed < end && strayed > start_t_ + rounding(end);
}

// Makes the step again, to `end` or less far; what ends it is kept if it is beyond a switch.
SundialsIntegrator::Step SundialsIntegrator::step_from_start(double end) {
  restart(start_t_, start_y_.data());
  system_.hold_switches(start_t_, start_on_.get());
  begin(end);
  const Step step = make_step(end);
  if (step == Step::made) read_switches(g_, gdot_, on_.get());
  return step;
}

// Takes the step, which has gone beyond switch i, back to its zero, and begins anew there, a rounding beyond it; or to
// where the error test has cut it short before.
SundialsIntegrator::Step SundialsIntegrator::search(std::size_t i, double end) {
  Bracket bracket(start_t_, start_g_[i], t_, g_[i]);
  const double nearest = std::max(nearest_share * (t_ - start_t_), rounding(t_));
  double next = bracket.kept(estimate(i), nearest);
  for (int k = 0; k < most_trials && bracket.width() > 2 * nearest; ++k) {
    if (const Step step = step_from_start(next); step != Step::made) return step;
    if (!(t_ > bracket.low() && t_ < bracket.high())) {
      begin(end);
      return Step::made;
    }
    if (crossed(i)) keep_high();
    bracket.put(t_, g_[i]);
    next = bracket.next(nearest);
  }
  restart(high_t_, high_y_.data());
  read_switches(g_, gdot_, on_.get());
  begin(end);
  return Step::made;
}

// s: the zero of the cubic through a switch's values and rates at both ends of the step; of the straight line, where
// rates are not known.
double SundialsIntegrator::estimate(std::size_t i) const {
  const double h = t_ - start_t_;
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
  return start_t_ + low * h;
}

}  // namespace gelenk
