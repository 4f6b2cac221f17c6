// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/simulation_impl.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <utility>

#include "integrator/integrator.h"
#include "outputs/port_readings.h"
#include "outputs/wrenches.h"
#include "preparation/report.h"
#include "simulation/parameters.h"
#include "util/text.h"

namespace gelenk {

int Simulation::Impl::checked_input(int index) const {
  if (index < 0 || index >= static_cast<int>(inputs.size())) {
    throw std::out_of_range("input " + std::to_string(index) + " of " + std::to_string(inputs.size()));
  }
  return index;
}

// Finite derivatives may lead to an infinite value at the end of the step.
void Simulation::Impl::check_inputs(double end) const {
  if (!u.moving()) return;
  for (int i = 0; i < static_cast<int>(inputs.size()); ++i) {
    if (std::isfinite(u.derivative_at(i, 0, end))) continue;
    throw StepError(
        describe_failed_step(at_time(end) + inputs[i].name + " would not be finite, given the derivatives set", time));
  }
}

// Unless a number is given, long communication steps may take more evaluations than those of a control loop.
long Simulation::Impl::permitted_evaluations(double span) const {
  if (scene.solver.max_evaluations != Solver::default_evaluations) return scene.solver.max_evaluations;
  constexpr double steps = 1000;
  const double step = scene.solver.step > 0 ? scene.solver.step : scene.experiment.step;
  const double most = scene.solver.max_evaluations * std::max(1.0, span / std::min(1.0, steps * step));
  return most < static_cast<double>(LONG_MAX) ? static_cast<long>(most) : LONG_MAX;
}

// A step to `end` that ended at t, since this number of evaluations did not suffice.
std::string Simulation::Impl::describe_cut_step(double t, double end, long evaluations) const {
  std::string obstacle;
  for (const auto& island : islands) {
    if (obstacle.empty()) obstacle = island->obstacle();
  }
  return describe_exhausted_budget(t, end, evaluations, obstacle);
}

// Advances all islands to `end`, or to the time at which the first of them exhausts its evaluation budget; returns the
// time reached. moved: number of islands that may have left the start of the step.
double Simulation::Impl::advance_islands(double end, bool continues, bool logged, std::size_t& moved) {
  const long evaluations = permitted_evaluations(end - time);
  for (const auto& island : islands) {
    ++moved;
    end = island->advance(end, evaluations, continues);
  }
  // Islands that went further go there again. Steps to another end may take more evaluations than before, and those of
  // a motion that has become chaotic far more: then all go half as far.
  constexpr int most_repetitions = 6;
  constexpr long least = 1000;
  const long enough = evaluations < LONG_MAX / 4 ? 2 * evaluations + least : LONG_MAX;
  for (int i = 0; i < most_repetitions; ++i) {
    const double common = end;
    for (const auto& island : islands) {
      if (island->time() == end) continue;
      roll_back(*island, logged);
      end = island->advance(end, enough, continues);
    }
    if (end == common) return end;
    if (i > 0) end = time + (end - time) / 2;
  }
  throw IntegrationError(at_time(end) +
                         "the parts of the mechanism that do not affect each other reach no common time");
}

// Motions that are known by values keep the value set last, also where it is not set again.
void Simulation::Impl::renew_motions() {
  u.renew([this](int input, Inputs::Change change) {
    if (change != Inputs::Change::none) notify_of_input(input, change == Inputs::Change::jump);
  });
}

void Simulation::Impl::notify_of_input(int input, bool jumped) {
  for (const int island : islands_of_input[static_cast<std::size_t>(input)]) islands[island]->inputs_changed(jumped);
  for (const int island : islands_showing_input[static_cast<std::size_t>(input)]) islands[island]->outputs_changed();
}

void Simulation::Impl::advance(double end) {
  std::string cause;
  std::size_t moved = 0;
  const bool continues = cut_short && !u.moving() && log.ends_with(u);
  const bool logged = !continues && any_integrator(islands, &Integrator::will_have_history);
  if (logged) log.add(u);
  try {
    const long evaluations = permitted_evaluations(end - time);
    const double reached = advance_islands(end, continues, logged, moved);
    time = reached;
    cut_short = reached < end;
    if (reached == end) return u.finish(end);
    u.interrupt(reached);
    throw StepBudgetError(describe_cut_step(reached, end, evaluations));
  } catch (const IntegrationError& fault) {
    cause = fault.what();
  } catch (const SingularMass& fault) {
    cause = describe_lost_inertia(time, fault.what());
  }
  // As if the step had not been tried.
  for (std::size_t i = 0; i < moved; ++i) roll_back(*islands[i], logged);
  if (logged) log.forget_last();
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

double Simulation::Impl::law_excess() {
  double out = 0;
  for (const auto& island : islands) out = std::max(out, island->law_audit().excess());
  return out;
}

// The largest magnitude among the constraint errors or their rates [m, rad, or per s].
double Simulation::Impl::max_constraint_error(const std::vector<double>& (Kinematics::*errors)() const) {
  double angle = 0;
  double length = 0;
  for (const auto& island : islands) {
    island->realize(Stage::velocity);
    const Kinematics& at = island->dynamics();
    const std::vector<double>& rows = (at.*errors)();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double& largest = at.row_is_angle(static_cast<int>(r)) ? angle : length;
      largest = std::max(largest, std::abs(rows[r]));
    }
  }
  return std::max(angle, scene.units.length * length);
}

void Simulation::step_to(double end) {
  Impl& s = *impl_;
  if (!s.runs) throw UsageError("step_to() was called before initialize()");
  if (!std::isfinite(end)) throw UsageError("the end of the step is not a finite number");
  if (end < s.time) {
    throw UsageError(at_time(end) + "the end of the step is before the present time " + std::to_string(s.time) + " s");
  }
  if (end <= s.time) return;
  s.renew_motions();
  s.check_inputs(end);
  const long before = s.evaluations();
  const auto count = [&] { s.worst_step = std::max(s.worst_step, s.evaluations() - before); };
  try {
    s.advance(end);
  } catch (const StepBudgetError&) {
    count();  // its part of the step is not undone
    throw;
  }
  count();
}

long Simulation::Impl::evaluations() const {
  long sum = 0;
  for (const auto& island : islands) sum += island->counts().evaluations;
  return sum;
}

void Simulation::serialize(Archive& archive) {
  Impl& s = *impl_;
  if (!s.runs) throw UsageError("a run cannot be saved or restored before initialize()");
  archive.serialize(s.time, s.cut_short, s.worst_step);
  s.u.serialize(archive);
  if (s.cut_short) s.log.serialize_last(archive);
  for (const auto& island : s.islands) island->serialize(archive);
  s.serialize_replay(archive);
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
                     ", expected a finite number; the former value is kept");
  const Inputs::Change change = s.u.set(s.checked_input(index), value / s.input_size[index]);
  if (change != Inputs::Change::none && s.initialized) s.notify_of_input(index, change == Inputs::Change::jump);
}

void Simulation::set_input_derivative(int index, int order, double value) {
  const std::string fault = Inputs::fault(order, value);
  if (!fault.empty()) throw UsageError(impl_->inputs.at(index).name + ": " + fault);
  Impl& s = *impl_;
  const int known = s.checked_input(index);
  s.u.set_derivative(known, order, value / s.input_size[known]);
  if (s.initialized) s.notify_of_input(known, false);
}

double Simulation::input(int index) const {
  const int known = impl_->checked_input(index);
  return impl_->input_size[known] * impl_->u.given(known);
}

double Simulation::input_derivative(int index, int order) const {
  if (order < 1 || order > Inputs::highest_order) throw UsageError("the order of a derivative must be 1 to 5");
  const int known = impl_->checked_input(index);
  return impl_->input_size[known] * impl_->u.derivative(known, order);
}

double Simulation::output(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("outputs are not available before initialize()");
  if (s.readings->is_of_whole(index)) return s.output_size[index] * s.readings->of_energy(index, s.energy());
  if (s.readings->island(index) < 0) return s.output_size[index] * s.readings->constant(index);
  Island& island = *s.islands[s.readings->island(index)];
  try {
    island.realize(s.readings->stage(index));
  } catch (const SingularMass& fault) {
    throw StepError(describe_lost_inertia(s.time, fault.what()));
  }
  return s.output_size[index] * s.readings->value(index, island.reading());
}

Pose3 Simulation::body_pose(int body) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("poses are not available before initialize()");
  const BodyPlace& place = s.prepared.reduced.bodies.at(static_cast<std::size_t>(body));
  Pose3 X_WB = place.X_LB;  // of an immobile body
  if (place.island >= 0) {
    Island& island = *s.islands[place.island];
    island.realize(Stage::velocity);
    X_WB = pose_in_world(s.prepared.reduced, place, island.dynamics().readings());
  }
  X_WB.p *= s.scene.units.size_of("m");
  return X_WB;
}

std::vector<BodyWrench> Simulation::wrenches() try {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("forces are not available before initialize()");
  BodyWrenches found(s.scene, s.prepared.reduced);
  for (std::size_t i = 0; i < s.islands.size(); ++i) {
    s.islands[i]->realize(Stage::acceleration);
    Island& island = *s.islands[i];
    const double* u = island.dynamics().readings().all_signals(island.formulation().drives().u().data());
    found.add(static_cast<int>(i), island.reading(), island.loads(), u);
  }
  found.add_immobile(s.u.now());
  for (BodyWrench& wrench : found.all) {
    wrench.p *= s.scene.units.size_of("m");
    wrench.f *= s.scene.units.size_of("N");
    wrench.n *= s.scene.units.size_of("N.m");
  }
  return std::move(found.all);
} catch (const SingularMass& fault) {
  throw StepError(describe_lost_inertia(impl_->time, fault.what()));
}

double Simulation::diagnostic(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("diagnostics are not available before initialize()");
  double sum = 0, iterations = 0, residual = 0, scheme = 0, step_error = 0;
  for (const auto& island : s.islands) {
    const RunCounts counts = island->counts();
    sum += static_cast<double>(counts.of(static_cast<Diagnostic>(index)));
    iterations = std::max(iterations, static_cast<double>(counts.cone_iterations));
    residual = std::max(residual, counts.cone_residual);
    scheme = std::max(scheme, static_cast<double>(counts.scheme));
    step_error = std::max(step_error, counts.step_error);
  }
  switch (static_cast<Diagnostic>(index)) {
    case Diagnostic::cone_residual:
      return s.diagnostic_size[index] * residual;
    case Diagnostic::cone_iterations:
      return iterations;
    case Diagnostic::scheme:
      return scheme;
    case Diagnostic::step_error:
      return std::max(1.0, s.scene.units.length) * step_error;  // of angles, or of lengths
    case Diagnostic::law_excess:
      return s.law_excess();
    case Diagnostic::worst_step:
      return static_cast<double>(s.worst_step);
    case Diagnostic::constraint_position:
      return s.max_constraint_error(&Kinematics::Phi);
    case Diagnostic::constraint_velocity:
      return s.max_constraint_error(&Kinematics::row_rates);
    case Diagnostic::kinetic_energy:
      return s.diagnostic_size[index] * s.energy().kinetic;
    case Diagnostic::potential_energy:
      return s.diagnostic_size[index] * s.energy().potential;
    case Diagnostic::total_energy:
      return s.diagnostic_size[index] * (s.energy().kinetic + s.energy().potential);
    default:
      return sum;
  }
}

}  // namespace gelenk
