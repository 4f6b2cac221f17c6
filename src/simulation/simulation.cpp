// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/simulation_impl.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <utility>

#include "integrator/integrator.h"
#include "preparation/report.h"
#include "simulation/parameters.h"
#include "util/text.h"

namespace gelenk {

int Simulation::Impl::known_input(int index) const {
  if (index < 0 || index >= static_cast<int>(inputs.size())) {
    throw std::out_of_range("input " + std::to_string(index) + " of " + std::to_string(inputs.size()));
  }
  return index;
}

// Derivatives may be finite and what they lead to not.
void Simulation::Impl::check_inputs(double end) const {
  if (!u.moving()) return;
  for (int i = 0; i < static_cast<int>(inputs.size()); ++i) {
    if (std::isfinite(u.derivative_at(i, 0, end))) continue;
    throw StepError(describe_failed_step(
        at_time(end) + inputs[i].name + " would be no finite number, by the derivatives set", time));
  }
}

// To `end`, or where an island's evaluations are budget_exhausted, there all of them; returns the time. moved: how many
// islands are not, or may be not, where the step began.
double Simulation::Impl::advance_islands(double end, bool continues, std::size_t& moved) {
  for (const auto& island : islands) {
    ++moved;
    end = island->advance(end, scene.solver.max_evaluations, continues);
  }
  // Those that were ahead have been further within their evaluations.
  for (const auto& island : islands) {
    if (island->time() == end) continue;
    island->roll_back();
    island->advance(end, LONG_MAX, continues);
  }
  return end;
}

void Simulation::Impl::advance(double end) {
  std::string cause;
  std::size_t moved = 0;
  const bool continues = cut_short && !u.moving() && log.ends_with(u);
  if (!continues && any_integrator(islands, &Integrator::will_have_history)) log.add(u);
  try {
    const double reached = advance_islands(end, continues, moved);
    time = reached;
    cut_short = reached < end;
    if (reached == end) return u.finish(end);
    u.interrupt(reached);
    throw StepBudgetError(describe_exhausted_budget(reached, end, scene.solver.max_evaluations));
  } catch (const IntegrationError& fault) {
    cause = fault.what();
  } catch (const SingularMass& fault) {
    cause = describe_lost_inertia(time, fault.what());
  }
  for (std::size_t i = 0; i < moved; ++i) islands[i]->roll_back();
  throw StepError(describe_failed_step(cause, time));
}

Energy Simulation::Impl::energy() {
  Energy sum;
  sum.potential = immobile_energy;
  for (const auto& island : islands) {
    island->realize(Stage::velocity);
    const Energy part = island->dynamics().readings().energy();
    sum.kinetic += part.kinetic;
    sum.potential += part.potential;
  }
  return sum;
}

// m or rad, in SI, or their rates.
double Simulation::Impl::largest_gap(const std::vector<double>& (Kinematics::*of)() const) {
  double angle = 0;
  double length = 0;
  for (const auto& island : islands) {
    island->realize(Stage::velocity);
    const Kinematics& at = island->dynamics();
    const std::vector<double>& rows = (at.*of)();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double& most = at.row_is_angle(static_cast<int>(r)) ? angle : length;
      most = std::max(most, std::abs(rows[r]));
    }
  }
  return std::max(angle, scene.units.length * length);
}

void Simulation::step_to(double end) {
  Impl& s = *impl_;
  if (!s.runs) throw UsageError("a step before initialize()");
  if (!std::isfinite(end)) throw UsageError("the end of a step is not a finite number");
  if (end < s.time) {
    throw UsageError(at_time(end) + "lies before the plant's time " + std::to_string(s.time) + " s");
  }
  if (end <= s.time) return;
  s.check_inputs(end);
  s.advance(end);
}

void Simulation::serialize(Archive& archive) {
  Impl& s = *impl_;
  if (!s.runs) throw UsageError("a record of a run before initialize()");
  archive.serialize(s.time);
  s.u.serialize(archive);
  for (const auto& island : s.islands) island->serialize(archive);
  s.exchange_past(archive);
  s.cut_short = false;
}

double Simulation::time() const { return impl_->time; }
const Scene& Simulation::scene() const { return impl_->given; }
const ModelSize& Simulation::size() const { return impl_->size; }
const std::vector<Signal>& Simulation::inputs() const { return impl_->inputs; }
const std::vector<Signal>& Simulation::outputs() const { return impl_->outputs; }
const std::vector<Signal>& Simulation::diagnostics() const { return impl_->diagnostics; }

void Simulation::set_input(int index, double value) {
  Impl& s = *impl_;
  if (!std::isfinite(value))
    throw UsageError(s.inputs.at(index).name + ": found " + std::to_string(value) +
                     ", expected a finite number; the former value stays");
  const Inputs::Change change = s.u.set(s.known_input(index), value / s.input_size[index]);
  if (change == Inputs::Change::none || !s.initialized) return;
  if (const int island = s.island_of_input[index]; island >= 0) {
    s.islands[island]->inputs_changed(change == Inputs::Change::jump);
  }
}

void Simulation::set_input_derivative(int index, int order, double value) {
  const std::string fault = Inputs::fault(order, value);
  if (!fault.empty()) throw UsageError(impl_->inputs.at(index).name + ": " + fault);
  const int known = impl_->known_input(index);
  impl_->u.set_derivative(known, order, value / impl_->input_size[known]);
}

double Simulation::input(int index) const {
  const int known = impl_->known_input(index);
  return impl_->input_size[known] * impl_->u.value(known);
}

double Simulation::input_derivative(int index, int order) const {
  if (order < 1 || order > Inputs::highest_order) throw UsageError("a derivative is of order 1 to 5");
  const int known = impl_->known_input(index);
  return impl_->input_size[known] * impl_->u.derivative(known, order);
}

double Simulation::output(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("an output before initialize()");
  if (s.readings->is_of_whole(index)) return s.output_size[index] * s.readings->of_energy(index, s.energy());
  if (s.readings->island(index) < 0) return s.output_size[index] * s.readings->constant(index);
  Island& island = *s.islands[s.readings->island(index)];
  island.realize(s.readings->stage(index));
  return s.output_size[index] * s.readings->value(index, island.reading());
}

Pose3 Simulation::body_pose(int body) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a pose before initialize()");
  const BodyPlace& place = s.prepared.reduced.bodies.at(static_cast<std::size_t>(body));
  Pose3 X_WB = place.X_LB;  // of what stands still
  if (place.island >= 0) {
    Island& island = *s.islands[place.island];
    island.realize(Stage::velocity);
    const StateReadings& readings = island.dynamics().readings();
    const Pose3 X_0L = place.rod >= 0 ? readings.rod_pose(place.rod) : readings.link_pose(place.link);
    X_WB = s.prepared.reduced.islands[place.island].X_W0 * X_0L * place.X_LB;
  }
  X_WB.p *= s.scene.units.size_of("m");
  return X_WB;
}

double Simulation::diagnostic(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a diagnostic before initialize()");
  const auto total = [&](long RunCounts::* count) {
    long sum = 0;
    for (const auto& island : s.islands) sum += island->counts().*count;
    return static_cast<double>(sum);
  };
  switch (static_cast<Diagnostic>(index)) {
    case Diagnostic::steps:
      return total(&RunCounts::steps);
    case Diagnostic::rejected_steps:
      return total(&RunCounts::rejected_steps);
    case Diagnostic::jacobians:
      return total(&RunCounts::jacobians);
    case Diagnostic::singular_positions:
      return total(&RunCounts::singular_positions);
    case Diagnostic::events:
      return total(&RunCounts::events);
    case Diagnostic::evaluations:
      return total(&RunCounts::evaluations);
    case Diagnostic::constraint_position:
      return s.largest_gap(&Kinematics::Phi);
    case Diagnostic::constraint_velocity:
      return s.largest_gap(&Kinematics::row_rates);
    case Diagnostic::kinetic_energy:
      return s.diagnostic_size[index] * s.energy().kinetic;
    case Diagnostic::potential_energy:
      return s.diagnostic_size[index] * s.energy().potential;
    case Diagnostic::total_energy:
      break;
  }
  const Energy energy = s.energy();
  return s.diagnostic_size[index] * (energy.kinetic + energy.potential);
}

}  // namespace gelenk
