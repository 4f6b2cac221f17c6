// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulation/projection.h"
#include "integrator/integrator.h"
#include "simulation/choose.h"
#include "simulation/outputs.h"
#include "simulation/report.h"
#include "simulation/start.h"

namespace gelenk {
namespace {

double largest(const std::vector<double>& x) {
  double max = 0;
  for (const double value : x) max = std::max(max, std::abs(value));
  return max;
}

}  // namespace

struct Simulation::Impl {
  explicit Impl(Scene given)
      : scene(std::move(given)),
        mechanism(compile(scene)),
        loads(make_loads(scene, mechanism)),
        dynamics(make_dynamics(mechanism, loads)),
        inputs(input_signals(scene)),
        outputs(output_signals(scene)),
        diagnostics(diagnostic_signals()),
        u(inputs.size(), 0.0),
        equations(mechanism, *dynamics, u),
        readings(scene, mechanism, outputs),
        y(mechanism.nq + mechanism.nv, 0.0),
        vdot(mechanism.nv, 0.0) {
    size.bodies = static_cast<int>(mechanism.links.size()) - 1;
    size.coordinates = mechanism.nq;
    size.speeds = mechanism.nv;
    size.rows = mechanism.rows;
    size.planar = mechanism.planar;
  }

  const Scene scene;
  const Mechanism mechanism;
  const Loads loads;
  std::unique_ptr<Dynamics> dynamics;
  std::vector<Signal> inputs, outputs, diagnostics;
  std::vector<double> u;
  Projection equations;
  Outputs readings;
  ModelSize size;
  std::unique_ptr<Integrator> integrator;

  double time = 0;
  std::vector<double> y, vdot;
  std::vector<double> backup;
  Outputs::Needs fresh = Outputs::Needs::state;  // what `dynamics` holds for (time, y, u)
  bool initialized = false;
  bool inputs_jumped = false;
  long evaluations_before = 0;  // made by initialize()
  std::vector<int> independent;
  std::string report;

  const double* q() const { return y.data(); }
  const double* v() const { return y.data() + mechanism.nq; }

  // Brings `dynamics` up to what an output needs.
  void refresh(Outputs::Needs needs) {
    if (needs <= fresh) return;
    dynamics->set_position(q());
    if (needs == Outputs::Needs::accelerations) dynamics->factorise();
    dynamics->set_velocity(v());
    if (needs == Outputs::Needs::accelerations) {
      dynamics->solve(u.data(), vdot.data());
      dynamics->set_acceleration(vdot.data());
    }
    fresh = needs;
  }

  void place_start();
  void find_independent();
  void start_integrator(double tolerance);
  void advance(double end);
};

void Simulation::Impl::place_start() {
  const StartWishes wishes = start_wishes(scene, mechanism);
  try {
    const Assembled found = assemble(mechanism, *dynamics, wishes.tree, wishes.cuts);
    std::ranges::copy(found.q, y.begin());
    std::ranges::copy(found.v, y.begin() + mechanism.nq);
    dynamics->normalise(y.data());
    dynamics->set_position(found.q.data());
    dynamics->factorise();  // tells parts that move without inertia
    size.rank = structural_rank(mechanism, *dynamics, found.q);
    size.freedoms = size.speeds - size.rank;
    report = describe_assembly(scene, mechanism, found);
  } catch (const CannotAssemble& fault) {
    throw AssemblyError(describe_failure(scene, mechanism, fault));
  } catch (const SingularMass& fault) {
    throw SceneError({describe_massless(scene, fault.what())});
  }
  equations.count_from(wishes.cuts.q, time, y.data());
}

void Simulation::Impl::find_independent() {
  independent.clear();
  const std::vector<double> position(y.begin(), y.begin() + mechanism.nq);
  const auto speeds = independent_speeds(mechanism, *dynamics, position, size.rank, preferred_speeds(scene, mechanism));
  for (int i = 0; i < static_cast<int>(outputs.size()); ++i) {
    const Signal& s = outputs[i];
    if (s.level != 0) continue;
    const JointPlace& place = mechanism.joints[s.joint];
    if (place.role != JointPlace::Role::tree) continue;
    // A quaternion counts if all three turns are free.
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const bool quaternion = kind.has_quaternion() && s.component >= kind.nq - 4;
    const int first = place.iv + (quaternion ? kind.nv - 3 : s.component);
    const int last = quaternion ? first + 2 : first;
    const auto free = [&](int k) { return std::ranges::find(speeds, k) != speeds.end(); };
    if (free(first) && free(last) && free((first + last) / 2)) independent.push_back(i);
  }
}

void Simulation::Impl::start_integrator(double tolerance) {
  IntegratorOptions options;
  options.tolerance = tolerance > 0 ? tolerance : scene.experiment.tolerance;
  options.step = scene.solver.step > 0 ? scene.solver.step : scene.experiment.step;
  integrator = make_integrator(choose_integrator(scene, mechanism, *dynamics, y, u), equations, options);
  integrator->restart(time, y.data());
}

void Simulation::Impl::advance(double end) {
  backup = y;
  fresh = Outputs::Needs::state;
  try {
    if (inputs_jumped) integrator->inputs_changed();
    inputs_jumped = false;
    integrator->advance(end, y.data());
    time = end;
  } catch (const IntegrationError& fault) {
    y = backup;
    equations.count_from(equations.cut_coordinates(), time, y.data());
    integrator->restart(time, y.data());
    throw StepError(describe_refusal(fault.what(), time));
  } catch (const SingularMass& fault) {
    y = backup;
    integrator->restart(time, y.data());
    throw StepError(describe_refusal(describe_massless(scene, fault.what()), time));
  }
}

Simulation::Simulation(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::initialize(double time, double tolerance) {
  Impl& s = *impl_;
  if (!std::isfinite(time)) throw UsageError("the start time is not a finite number");
  s.time = time;
  s.initialized = false;
  s.fresh = Outputs::Needs::state;
  s.place_start();
  s.find_independent();
  s.start_integrator(tolerance);
  s.evaluations_before = s.dynamics->evaluations();
  s.initialized = true;
}

void Simulation::step_to(double end) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a step before initialize()");
  if (!std::isfinite(end)) throw UsageError("the end of a step is not a finite number");
  if (end < s.time) {
    throw UsageError(at_time(end) + "lies before the plant's time " + std::to_string(s.time) + " s");
  }
  if (end > s.time) s.advance(end);
}

double Simulation::time() const { return impl_->time; }
const Scene& Simulation::scene() const { return impl_->scene; }
const ModelSize& Simulation::size() const { return impl_->size; }
const std::vector<Signal>& Simulation::inputs() const { return impl_->inputs; }
const std::vector<Signal>& Simulation::outputs() const { return impl_->outputs; }
const std::vector<Signal>& Simulation::diagnostics() const { return impl_->diagnostics; }
const std::vector<int>& Simulation::independent_coordinates() const { return impl_->independent; }
std::string Simulation::assembly_report() const { return impl_->report; }

void Simulation::set_input(int index, double value) {
  Impl& s = *impl_;
  if (!std::isfinite(value))
    throw UsageError(s.inputs.at(index).name + ": found " + std::to_string(value) +
                     ", expected a finite number; the former value stays");
  if (s.u.at(index) == value) return;
  s.u[index] = value;
  s.inputs_jumped = true;
  s.fresh = Outputs::Needs::state;
}

double Simulation::input(int index) const { return impl_->u.at(index); }

double Simulation::output(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("an output before initialize()");
  s.refresh(s.readings.needs(index));
  return s.readings.value(index, *s.dynamics, s.y.data(), s.vdot.data(), s.equations.cut_coordinates());
}

double Simulation::diagnostic(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a diagnostic before initialize()");
  switch (static_cast<Diagnostic>(index)) {
    case Diagnostic::steps:
      return static_cast<double>(s.integrator->steps());
    case Diagnostic::rejected_steps:
      return static_cast<double>(s.integrator->rejected_steps());
    case Diagnostic::evaluations:
      return static_cast<double>(s.dynamics->evaluations() - s.evaluations_before);
    default:
      break;
  }
  s.refresh(Outputs::Needs::velocities);
  const Energy energy = s.dynamics->energy();
  switch (static_cast<Diagnostic>(index)) {
    case Diagnostic::constraint_position:
      return largest(s.dynamics->Phi());
    case Diagnostic::constraint_velocity:
      return largest(s.dynamics->row_rates());
    case Diagnostic::kinetic_energy:
      return energy.kinetic;
    case Diagnostic::potential_energy:
      return energy.potential;
    default:
      return energy.kinetic + energy.potential;
  }
}

}  // namespace gelenk
