// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/placement.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "scene/touching_laws.h"
#include "simulation/sensitivity.h"
#include "simulation/simulation_impl.h"
#include "simulation/state_derivatives.h"
#include "util/text.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of the loops, in one part of the way [rad, natural units of length]: within it Newton's method remains on the branch.
constexpr double longest_part = 0.1;
// Relative to the states: rounding errors of closing the loops. Newton's method is continued until it no longer gains.
constexpr double accuracy = 1e-11;
// An iteration that begins this close ends at rounding errors, since convergence is quadratic.
constexpr double last_iteration = 1e-9;
constexpr int most_iterations = 10'000;

bool has_contacts(const Island& island) {
  const ContactMotion& contacts = island.formulation().contacts();
  return contacts.located() != nullptr || contacts.are_used();
}

// For messages: laws of joints are contacts to the equations, but not to the user.
std::string what_touches(const Scene& scene) {
  return scene.contacts.empty() ? path_of_touching_law(scene, 0) : "contacts between shapes";
}

}  // namespace

struct Placement::Position {
  std::vector<Island::Position> islands;
  double time;
};

std::shared_ptr<const Placement::Position> Placement::position() const {
  auto out = std::make_shared<Position>();
  for (const auto& island : impl_.islands) out->islands.push_back(island->position());
  out->time = impl_.time;
  return out;
}

void Placement::return_to(const Position& at) {
  if (at.islands.size() != impl_.islands.size()) throw UsageError("the position is not of this plant");
  for (std::size_t i = 0; i < at.islands.size(); ++i) impl_.islands[i]->place(at.islands[i], at.time);
  impl_.time = at.time;
}

bool Placement::has_loops() const {
  return std::ranges::any_of(impl_.islands, [](const auto& island) { return island->prepared().mechanism.rows > 0; });
}

// What the states lack to be x, in natural units.
VectorXd Placement::remaining(std::span<const double> x) const {
  VectorXd out(static_cast<Index>(x.size()));
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Sensitivity::Place at = impl_.sensitivity->place(k);
    const Island& island = *impl_.islands[static_cast<std::size_t>(at.island)];
    const Reading& reading = island.reading();
    const double* const among = at.of == Sensitivity::Place::Of::coordinates  ? reading.q
                                : at.of == Sensitivity::Place::Of::velocities ? reading.v
                                                                              : reading.states;
    const double present = at.sign * among[at.component];
    out[static_cast<Index>(k)] = x[k] / impl_.output_size[impl_.states[k]] - present;
  }
  for (std::size_t k = 0; k + 3 < x.size(); ++k) {
    const Signal& signal = impl_.outputs[impl_.states[k]];
    if (signal.joint < 0 || signal.derivative >= 0) continue;
    keep_independent_rotations(k, out);
    k += 3;
  }
  return out;
}

// Of the change of the quaternion that begins at this state, removes the rotations that the loops determine.
void Placement::keep_independent_rotations(std::size_t state, VectorXd& change) const {
  const Sensitivity::Place at = impl_.sensitivity->place(state);
  const auto island = static_cast<std::size_t>(at.island);
  const JointPlace& joint = impl_.prepared.reduced.joints[impl_.outputs[impl_.states[state]].joint];
  const int first = joint.iv + static_cast<int>(joint.v_sign.size()) - 3;
  const std::vector<int>& independent = impl_.independent_by_island[island].coordinates;
  Eigen::Array3d kept;
  for (int i = 0; i < 3; ++i) kept[i] = std::ranges::find(independent, first + i) == independent.end() ? 0 : 1;
  if ((kept == 1).all()) return;
  const double* q = impl_.islands[island]->reading().q + at.component;
  const Eigen::Quaterniond Q(q[3], q[0], q[1], q[2]);
  auto dQ = change.segment<4>(static_cast<Index>(state));
  Eigen::Quaterniond turn = Q.conjugate() * Eigen::Quaterniond(dQ[3], dQ[0], dQ[1], dQ[2]);
  turn.vec() = turn.vec().array() * kept;
  turn.w() = 0;
  dQ = (Q * turn).coeffs();
}

// Islands without loops take the states as they are.
void Placement::move(const VectorXd& dx, double time) {
  Simulation::Impl& s = impl_;
  for (std::size_t i = 0; i < s.islands.size(); ++i) {
    const Mechanism& mechanism = s.islands[i]->prepared().mechanism;
    VectorXd change = VectorXd::Zero(mechanism.nq + mechanism.nv + static_cast<Index>(mechanism.states.size()));
    if (mechanism.rows > 0) {
      change = s.sensitivity->displacement(static_cast<int>(i), dx);
    } else {
      for (std::size_t k = 0; k < s.states.size(); ++k) {
        const Sensitivity::Place at = s.sensitivity->place(k);
        if (at.island != static_cast<int>(i)) continue;
        const int first = at.of == Sensitivity::Place::Of::coordinates  ? 0
                          : at.of == Sensitivity::Place::Of::velocities ? mechanism.nq
                                                                        : mechanism.nq + mechanism.nv;
        change[first + at.component] = at.sign * dx[static_cast<Index>(k)];
      }
    }
    if (!s.islands[i]->place(change, time)) throw UsageError("its loops cannot be closed on the way there");
  }
  s.time = time;
}

// Throws if it cannot be placed at these states.
void Placement::check_states(std::span<const double> x, double time) const {
  const Simulation::Impl& s = impl_;
  if (!s.initialized) throw UsageError("a simulation cannot be placed before it was assembled");
  if (x.size() != s.states.size()) {
    throw UsageError("states: found " + std::to_string(x.size()) + " numbers, expected " +
                     std::to_string(s.states.size()));
  }
  if (!std::ranges::all_of(x, [](double value) { return std::isfinite(value); }) || !std::isfinite(time))
    throw UsageError("states: found a number that is not finite");
}

void Placement::move_to(std::span<const double> x, double time) {
  if (impl_.runs) throw UsageError("only a simulation that was assembled can be placed");
  approach(x, time, true);
}

// closed: whether its loops are.
void Placement::approach(std::span<const double> x, double time, bool closed) {
  check_states(x, time);
  StateDerivatives(simulation_).prepare();
  const std::shared_ptr<const Position> before = position();
  try {
    const bool loops = has_loops();
    double last = INFINITY;
    for (int k = 0; k < most_iterations; ++k) {
      const VectorXd dx = remaining(x);
      const double size = dx.size() == 0 ? 0 : dx.cwiseAbs().maxCoeff();
      double scale = 1;
      for (const double value : x) scale = std::max(scale, std::abs(value));
      const bool whole = !loops || size <= longest_part;
      if (k > 0 && whole && (size == 0 || (size <= accuracy * scale && !(size < last / 2)))) return;
      move(whole ? dx : VectorXd(dx * (longest_part / size)), time);
      if (!loops || ((closed || k > 0) && whole && size <= last_iteration * scale)) return;
      last = whole ? size : INFINITY;
    }
    throw UsageError("its loops cannot be closed there");
  } catch (const std::exception& fault) {
    return_to(*before);
    const auto* known = dynamic_cast<const UsageError*>(&fault);
    throw UsageError(std::string("the mechanism cannot be moved to the given states: ") +
                     (known != nullptr ? known->what() : "its states do not determine it on the way there"));
  }
}

void Placement::follow(const Simulation& other, std::span<const double> x) {
  if (impl_.runs) throw UsageError("only a simulation that was assembled can be placed");
  take_inputs_and_modes(other, x, true);
  for (const auto& island : impl_.islands) realize_in_present_modes(*island);
}

// So that outputs are not those in the modes in which a step would begin, which may be about to change.
void Placement::realize_in_present_modes(Island& of) {
  EventModes& modes = of.equations_->modes();
  if (modes.locks().empty() || has_contacts(of)) return;
  const double* vdot = modes.locks().accelerations(of.time_, of.y_.data());
  if (vdot == nullptr || of.dynamics_->switching_forces().is_redundant()) return;
  std::copy_n(vdot, of.vdot_.size(), of.vdot_.begin());
  modes.outputs().record();
  of.dynamics_->readings().set_root_poses();
  of.dynamics_->set_acceleration(of.vdot_.data());
  of.realize_named(Stage::acceleration);
}

void Placement::start_from(const Simulation& other, std::span<const double> x) {
  const Simulation::Impl& from = *other.impl_;
  if (!impl_.runs || impl_.islands.size() != from.islands.size())
    throw UsageError("only another simulation of the scene can start there");
  if (std::ranges::any_of(impl_.islands, [](const auto& island) { return has_contacts(*island); }))
    throw UsageError("the modes of " + what_touches(impl_.scene) +
                     " cannot be taken over; end the run before this event, or use damping instead");
  for (std::size_t i = 0; i < impl_.islands.size(); ++i)
    impl_.islands[i]->place(from.islands[i]->position(), from.time);
  take_inputs_and_modes(other, x, false);
  for (std::size_t i = 0; i < impl_.islands.size(); ++i) impl_.islands[i]->start_again(*from.islands[i]);
}

void Placement::take_inputs_and_modes(const Simulation& other, std::span<const double> x, bool closed) {
  const Simulation::Impl& from = *other.impl_;
  if (from.states != impl_.states) throw UsageError("it has other states than with the values given");
  if (from.input_size != impl_.input_size) throw UsageError("it has other natural units than with the values given");
  impl_.u = from.u;
  approach(x, from.time, closed);
  for (std::size_t i = 0; i < impl_.islands.size(); ++i) impl_.islands[i]->take_modes(*from.islands[i]);
}

std::string Placement::modes() const {
  for (const auto& island : impl_.islands) {
    if (!island->formulation().modes().locks().empty()) return "friction or limits";
    if (has_contacts(*island)) return what_touches(impl_.scene);
  }
  return {};
}

std::vector<double> Placement::rates() {
  std::vector<double> out;
  for (const int state : impl_.states) {
    const int rate = impl_.outputs[state].derivative;
    if (rate < 0) {
      const std::vector<double> still(impl_.states.size(), 0.0);
      const std::vector<double> held(impl_.u.count(), 0.0);
      const VectorXd all = StateDerivatives(simulation_).directional_derivative(still, held).xdot;
      return {all.begin(), all.end()};
    }
    out.push_back(simulation_.output(rate));
  }
  return out;
}

}  // namespace gelenk
