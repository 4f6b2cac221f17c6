// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/model_exchange.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "joint/kinds.h"
#include "preparation/report.h"
#include "scene/shapes.h"
#include "scene/touching_laws.h"
#include "simulation/exchanged_island.h"
#include "simulation/simulation_impl.h"
#include "simulation/state_derivatives.h"
#include "util/text.h"

namespace gelenk {

std::string ModelExchange::refusal(const Scene& scene) {
  for (const Signal& input : input_signals(scene)) {
    if (input.name.ends_with("_ref"))
      return input.name +
             " prescribes a motion, of which model exchange knows values but no time derivatives; use co-simulation, "
             "or "
             "move the joint by a force or torque";
  }
  const std::string reason = !has_touching_laws(scene) ? "" : reason_for_time_steps(scene);
  return reason.empty() ? "" : "contacts are solved in time steps, not at located events: " + reason;
}

Scene ModelExchange::prepared(Scene scene) {
  scene.solver.formulation = "udwadia-kalaba";
  scene.solver.integrator = "erk";  // none that makes time steps
  return scene;
}

int ModelExchange::indicators_of(const Scene& scene) {
  Simulation simulation(prepared(scene));
  simulation.assemble();
  int sum = 0;
  for (const auto& island : simulation.impl_->islands) sum += island->formulation().modes().indicators();
  return sum;
}

ModelExchange::ModelExchange(Simulation& of, std::vector<int> states)
    : simulation_(of), states_(std::move(states)), x_(states_.size()), xdot_(states_.size()), time_(of.time()) {
  Simulation::Impl& s = *of.impl_;
  StateDerivatives(of).prepare();
  std::vector<std::vector<ExchangedIsland::Slot>> slots(s.islands.size());
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const auto at = std::ranges::find(s.states, states_[k]);
    if (at == s.states.end()) throw UsageError(s.outputs.at(states_[k]).name + " is not a state");
    using Place = Sensitivity::Place;
    const Place place = s.sensitivity->place(static_cast<std::size_t>(at - s.states.begin()));
    const Mechanism& mechanism = s.islands[static_cast<std::size_t>(place.island)]->prepared().mechanism;
    const int first = place.of == Place::Of::coordinates  ? 0
                      : place.of == Place::Of::velocities ? mechanism.nq
                                                          : mechanism.nq + mechanism.nv;
    ExchangedIsland::Slot slot{
        .state = k, .entry = first + place.component, .size = place.sign * s.output_size[states_[k]]};
    if (place.of == Place::Of::coordinates) {
      const Signal& signal = s.outputs[states_[k]];
      const JointKind& kind = kind_of(*s.scene.joints[static_cast<std::size_t>(signal.joint)].is);
      const JointPlace& joint = s.prepared.reduced.joints[static_cast<std::size_t>(signal.joint)];
      slot.begins_quaternion = kind.has_quaternion() && signal.component == kind.nq - 4;
      if (slot.begins_quaternion) slot.speed = joint.iv + kind.nv - 3;
      if (!kind.is_of_quaternion(signal.component)) slot.speed = joint.iv + signal.component;
    }
    slots[static_cast<std::size_t>(place.island)].push_back(slot);
    x_[k] = of.output(states_[k]);
  }
  for (std::size_t i = 0; i < s.islands.size(); ++i)
    islands_.push_back(
        std::make_unique<ExchangedIsland>(*s.islands[i], std::move(slots[i]), s.independent_by_island[i]));
  save(before_);
}

ModelExchange::~ModelExchange() = default;
ModelExchange::ModelExchange(ModelExchange&&) noexcept = default;

int ModelExchange::indicators() const {
  int sum = 0;
  for (const auto& island : islands_) sum += island->indicators();
  return sum;
}

void ModelExchange::set_time(double t) {
  if (!std::isfinite(t)) throw UsageError("time: found " + text::number(t) + ", expected a finite number");
  if (t == time_) return;
  time_ = t;
  is_placed_ = false;
}

void ModelExchange::set_state(std::size_t state, double value) {
  if (!std::isfinite(value)) {
    throw UsageError(simulation_.outputs()[static_cast<std::size_t>(states_[state])].name + ": found " +
                     text::number(value) + ", expected a finite number");
  }
  if (value == x_[state]) return;
  x_[state] = value;
  is_placed_ = false;
}

void ModelExchange::set_states(std::span<const double> x) {
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(x[k])) set_state(k, x[k]);  // before any is set
  }
  for (std::size_t k = 0; k < x.size(); ++k) set_state(k, x[k]);
}

std::string ModelExchange::describe_lost(ExchangedIsland& island) const {
  if (island.is_too_far())
    return at_time(time_) +
           "the states are too far from those at the end of the last step (more than 100 rad); declare each step as "
           "completed, or jumps as events";
  const int state = island.blocked_state();
  if (state < 0) return at_time(time_) + "the loops cannot be closed at these states";
  const Simulation::Impl& s = *simulation_.impl_;
  const Signal& signal = s.outputs[states_[static_cast<std::size_t>(state)]];
  return at_time(time_) + "the states do not determine the position: joint " +
         s.scene.joints[static_cast<std::size_t>(signal.joint)].name +
         ", whose coordinate is a state, is at or near a limit of its motion";
}

template <class Body>
void ModelExchange::attempt(Body body) {
  try {
    body();
  } catch (const IntegrationError& fault) {
    throw StepError(fault.what());
  } catch (const SingularMass& fault) {
    throw StepError(describe_lost_inertia(time_, fault.what()));
  }
}

void ModelExchange::place() {
  if (is_placed_) return;
  simulation_.impl_->time = time_;
  is_shown_ = has_rates_ = false;
  attempt([&] {
    for (const auto& island : islands_) {
      if (!island->go_to(time_, x_.data())) throw StepError(describe_lost(*island));
    }
  });
  is_placed_ = true;
}

std::span<const double> ModelExchange::rates() {
  place();
  if (!has_rates_) {
    attempt([&] {
      for (const auto& island : islands_) island->rates(xdot_.data());
    });
  }
  has_rates_ = true;
  return xdot_;
}

void ModelExchange::indicator_values(double* z) {
  place();
  attempt([&] {
    for (const auto& island : islands_) {
      island->indicator_values(z);
      z += island->indicators();
    }
  });
}

void ModelExchange::show() {
  place();
  if (is_shown_) return;
  for (const auto& island : islands_) island->count_turns();
  is_shown_ = true;
}

bool ModelExchange::complete_step() {
  place();
  bool has_event = false;
  attempt([&] {
    for (const auto& island : islands_) has_event = island->complete_step() || has_event;
  });
  simulation_.impl_->u.finish(time_);
  has_rates_ = is_shown_ = false;
  return has_event;
}

ModelExchange::Event ModelExchange::pass_event() {
  place();
  save(before_);
  Event out;
  try {
    attempt([&] {
      for (const auto& island : islands_) {
        out.states_changed = island->pass_event(x_.data()) || out.states_changed;
        out.next_time = std::min(out.next_time, island->next_break());
      }
    });
  } catch (...) {
    before_.start_reading();
    serialize(before_);
    throw;
  }
  simulation_.impl_->u.finish(time_);
  has_rates_ = is_shown_ = false;
  return out;
}

void ModelExchange::save(Archive& archive) {
  archive.start_writing();
  serialize(archive);
}

void ModelExchange::serialize(Archive& archive) {
  archive.serialize(x_, time_, is_placed_);
  for (const auto& island : islands_) island->serialize(archive);
  simulation_.serialize(archive);
  if (!archive.reading()) return;
  for (const auto& island : islands_) island->continue_from_base();
  has_rates_ = is_shown_ = false;
}

}  // namespace gelenk
