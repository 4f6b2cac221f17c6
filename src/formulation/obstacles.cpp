// SPDX-License-Identifier: BSD-3-Clause
// Why a step fails: what is known of the equations at a state.
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "formulation/formulation.h"

namespace gelenk {
namespace {

// Ratio of smallest to largest pivot of the constraint Jacobian below which a dead center is reported as the cause of a
// failed step.
constexpr double dead_center_pivot_ratio = 0.1;

constexpr std::string_view held_back =
    "friction may be holding at rest what a prescribed motion moves: a motion that starts with zero velocity and zero "
    "acceleration, such as t^3, cannot be followed by a joint with friction";

// An element state on its way to infinity: its size, in its nominal size, and its rate of growth [1/s].
constexpr double lost_state = 1e4;
constexpr double lost_state_growth = 1e3;

// Describes a dead center at the position of the last factors of `dynamics`; empty: there is none.
std::string describe_dead_center(const Dynamics& dynamics) {
  if (dynamics.pivot_ratio() > dead_center_pivot_ratio) return {};
  return "a loop is near a dead center of its driven joint, beyond which the prescribed motion cannot be followed";
}

// Describes an element state of which the value or the rate is no number, or soon will be; `dynamics` is at
// y.
std::string describe_lost_state(const Mechanism& mechanism, Dynamics& dynamics, Drives& drives, const double* y) {
  if (drives.states() == 0) return {};
  const double* const states = y + drives.motion_size();
  std::vector<double> rates(static_cast<std::size_t>(drives.states()));
  drives.set_states(states);
  dynamics.readings().state_rates(drives.u().data(), rates.data());
  for (std::size_t k = 0; k < rates.size(); ++k) {
    const std::string& name = mechanism.state_names[k];
    const double size = std::abs(states[k]);
    if (size > lost_state && !(std::abs(rates[k]) < lost_state_growth * size))
      return "the state " + name + " grows without bound";
    if (!std::isfinite(rates[k])) return "the rate of the state " + name + " is not finite";
  }
  return {};
}

}  // namespace

std::string Formulation::obstacle(const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + mechanism_.nq);
  std::string reason = row_domain_.undefined_reason();
  if (reason.empty()) reason = modes_.indeterminacy();
  if (reason.empty() && mechanism_.driven()) {
    projector().refactorize();
    reason = describe_dead_center(dynamics_);
  }
  if (reason.empty()) reason = dynamics_.kinks().missing_value();
  if (reason.empty()) reason = contacts_.steps().failure();
  if (reason.empty() && mechanism_.driven() && modes_.locks().any_at_rest()) reason = held_back;
  return reason.empty() ? describe_lost_state(mechanism_, dynamics_, drives_, y) : reason;
}

}  // namespace gelenk
