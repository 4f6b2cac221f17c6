// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/impact_order.h"

#include <cmath>
#include <span>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::VectorXd;

// What errors of a run add up to, times its tolerance.
constexpr double accumulated_errors = 10;
// In a series of impacts that comes to an end, everything is near, and so slow that its accelerations soon reverse it;
// what is about to be struck moves by far more than these would let it rise.
constexpr double unaccelerated_fraction = 1e-3;
// Velocities that change by less than this part of the approach remain what they were.
constexpr double changed_fraction = 1e-3;

bool is_fast(double rate, double distance, double acceleration) {
  return std::abs(acceleration) * distance < unaccelerated_fraction * rate * rate;
}

// Whether an impact that follows, or has just been, may come before, or after, the present one by errors of the run.
// touched: within rounding, so that it takes part in the present one, although it moves away; then it has been struck
// just before, as in a series of impacts between several limits of which the times, but not the speeds, become small.
bool is_near(bool touched, double rate, double distance, double acceleration, double reach) {
  return touched ? rate > 0 && is_fast(rate, reach, acceleration)
                 : rate < 0 && distance < reach && is_fast(rate, distance, acceleration);
}

}  // namespace

void ImpactOrder::find(const double* y, int nq, const std::vector<double>& vdot) {
  near_.clear();
  const double* const v = y + nq;
  before_.assign(v, v + vdot.size());
  const double reach = accumulated_errors * joints_.tolerance();
  for (const JointImpacts::Bound& at : joints_.near_bounds(reach)) {
    const double rate = joints_.distance_rate(at, v);
    if (is_near(at.is_touched, rate, at.distance, joints_.distance_rate(at, vdot.data()), reach))
      near_.push_back({.indicator = at.indicator, .lock = at.lock, .side = at.side, .rate = rate});
  }
  ContactEquations& equations = contacts_.equations();
  for (int i = 0; i < equations.candidates().count(); ++i) {
    const bool may_meet = equations.candidates().is_close(i) && equations.candidates().is_near(i);
    if (!may_meet || contacts_.mode_of(i).closed) continue;
    const CandidateState state = equations.candidates().state(i);
    if (state.gap > reach) continue;
    ContactEquations::Rows rows;
    equations.build(std::span(&i, 1), equations.modes(), false, rows);
    const Index row = rows.entries.front().first;
    const double acceleration = rows.R.row(row).dot(Map<const VectorXd>(vdot.data(), rows.R.cols())) + rows.rates[row];
    if (!is_near(contacts_.may_touch(i), state.rate, state.gap, acceleration, reach)) continue;
    const int indicator = first_of_contacts_ + ContactModes::per_candidate * i;
    near_.push_back({.indicator = indicator, .rows = rows.R, .rate = state.rate});
  }
}

// How much the velocities with which it is struck have changed: along its normal, tangential and of rotation.
double ImpactOrder::change(const Near& of, const double* v) const {
  const Map<const VectorXd> before(before_.data(), static_cast<Index>(before_.size()));
  const VectorXd difference = Map<const VectorXd>(v, before.size()) - before;
  if (of.lock < 0) return (of.rows * difference).lpNorm<Eigen::Infinity>();
  return std::abs(joints_.distance_rate({.lock = of.lock, .side = of.side}, difference.data()));
}

int ImpactOrder::changed(const double* v) const {
  for (const Near& of : near_) {
    if (change(of, v) > changed_fraction * std::abs(of.rate)) return of.indicator;
  }
  return -1;
}

}  // namespace gelenk
