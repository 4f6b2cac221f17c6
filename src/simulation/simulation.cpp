// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "integrator/integrator.h"
#include "scene/text.h"
#include "simulation/island.h"
#include "simulation/parameters.h"
#include "simulation/report.h"
#include "simulation/start.h"

namespace gelenk {

ModelSize size_of(const ReducedScene& reduced) {
  ModelSize size;
  for (const Mechanism& mechanism : reduced.islands) {
    size.bodies += static_cast<int>(mechanism.links.size()) - 1;
    size.coordinates += mechanism.nq;
    size.speeds += mechanism.nv;
    size.rows += mechanism.rows;
    size.planar_islands += mechanism.planar ? 1 : 0;
  }
  size.islands = static_cast<int>(reduced.islands.size());
  size.planar = size.planar_islands == size.islands;
  return size;
}

struct Simulation::Impl {
  explicit Impl(Scene given)
      : scene(std::move(given)),
        reduced(reduce(scene)),
        inputs(input_signals(scene)),
        outputs(output_signals(scene)),
        diagnostics(diagnostic_signals()),
        u(inputs.size()),
        size(size_of(reduced)) {}

  Scene scene;
  const ReducedScene reduced;  // before the start values are known
  std::vector<Signal> inputs, outputs, diagnostics;
  Inputs u;
  ModelSize size;

  // From initialize() on.
  PreparedScene prepared;
  std::vector<std::unique_ptr<Island>> islands;
  std::vector<int> island_of_input;
  std::unique_ptr<Outputs> readings;
  std::optional<LoadMaker> load_maker;
  std::vector<Loads> other_loads;  // by island: to be filled in when tuned
  double still_energy = 0;         // J, potential, of what stands still
  double time = 0;
  bool initialized = false;
  std::vector<int> independent;
  std::vector<std::vector<int>> independent_by_island;  // speeds
  std::vector<StateVariable> states;
  std::unique_ptr<Sensitivity> sensitivity;  // made when first asked for

  void make_islands();
  void find_independent();
  int known_input(int index) const;  // throws std::out_of_range
  void check_inputs(double end) const;
  void advance(double end);
  Energy energy();
  std::vector<std::string> names_of_coordinates(int island) const;                     // independent ones
  std::vector<int> independent_of(int island, const std::vector<bool>& prefer) const;  // speeds
};

void Simulation::Impl::make_islands() {
  size = size_of(prepared.reduced);
  load_maker.emplace(scene, prepared.reduced);
  load_maker->fill(other_loads);
  std::vector<Loads> loads = make_loads(scene, prepared.reduced);
  sensitivity.reset();
  islands.clear();
  island_of_input.assign(u.count(), -1);
  size.rows = 0;
  for (std::size_t i = 0; i < prepared.islands.size(); ++i) {
    islands.push_back(std::make_unique<Island>(scene, prepared.islands[i], std::move(loads[i]), u, time));
    for (const int input : islands[i]->inputs()) island_of_input[input] = static_cast<int>(i);
    size.rows += islands[i]->mechanism().rows;
    size.rank += islands[i]->structure().rank;
  }
  size.freedoms = size.speeds - size.rank;
  readings = std::make_unique<Outputs>(scene, prepared.reduced, outputs);
  still_energy = standing_energy(scene, prepared.reduced);
}

void Simulation::Impl::find_independent() {
  independent.clear();
  independent_by_island.clear();
  std::vector<std::vector<bool>> is_free;  // by island, speed
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const Mechanism& mechanism = islands[i]->mechanism();
    const auto speeds =
        independent_of(static_cast<int>(i), preferred_speeds(scene, prepared.reduced, static_cast<int>(i)));
    is_free.emplace_back(mechanism.nv, false);
    for (const int k : speeds) is_free[i][k] = true;
    independent_by_island.push_back(speeds);
  }
  for (int i = 0; i < static_cast<int>(outputs.size()); ++i) {
    const Signal& s = outputs[i];
    if (s.level != 0) continue;
    const JointPlace& place = prepared.reduced.joints[s.joint];
    if (place.role != JointPlace::Role::tree) continue;
    // A quaternion counts if all three turns are free.
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const bool quaternion = kind.has_quaternion() && s.component >= kind.nq - 4;
    const int first = place.iv + (quaternion ? kind.nv - 3 : s.component);
    const int last = quaternion ? first + 2 : first;
    const std::vector<bool>& of_island = is_free[place.island];
    if (of_island[first] && of_island[last] && of_island[(first + last) / 2]) independent.push_back(i);
  }
  states = states_behind(scene, outputs, independent);
}

int Simulation::Impl::known_input(int index) const {
  inputs.at(static_cast<std::size_t>(index));
  return index;
}

// Derivatives may be finite and what they lead to not.
void Simulation::Impl::check_inputs(double end) const {
  if (!u.moving()) return;
  for (int i = 0; i < static_cast<int>(inputs.size()); ++i) {
    if (std::isfinite(u.derivative_at(i, 0, end))) continue;
    throw StepError(
        describe_refusal(at_time(end) + inputs[i].name + " would be no finite number, by the derivatives set", time));
  }
}

void Simulation::Impl::advance(double end) {
  std::string cause;
  std::size_t moved = 0;
  try {
    for (; moved < islands.size(); ++moved) islands[moved]->advance(end);
    time = end;
    u.finish(end);
    return;
  } catch (const IntegrationError& fault) {
    cause = fault.what();
  } catch (const SingularMass& fault) {
    cause = describe_lost_inertia(time, fault.what());
  }
  for (std::size_t i = 0; i <= moved; ++i) islands[i]->roll_back();
  throw StepError(describe_refusal(cause, time));
}

// prefer: by speed of the island, those wanted among them.
std::vector<int> Simulation::Impl::independent_of(int island, const std::vector<bool>& prefer) const {
  const Island& of = *islands[island];
  const Structure& structure = of.structure();
  const auto dynamics = make_dynamics(of.mechanism(), of.loads());  // the run's own stays as it is
  dynamics->limit_rank(structure.rank);
  // A singular start tells too little of what depends on what.
  const bool singular = structure.rank_start < structure.rank && !structure.idle_q.empty();
  const std::vector<double>& q = singular ? structure.idle_q : prepared.islands[island].start.q;
  return independent_speeds(of.mechanism(), *dynamics, q, structure.rank, prefer);
}

std::vector<std::string> Simulation::Impl::names_of_coordinates(int island) const {
  std::vector<std::string> out;
  for (const int q : independent) {
    if (prepared.reduced.joints[outputs[q].joint].island == island) out.push_back(outputs[q].name);
  }
  return out;
}

Energy Simulation::Impl::energy() {
  Energy sum;
  sum.potential = still_energy;
  for (const auto& island : islands) {
    island->refresh(Outputs::Needs::velocities);
    const Energy part = island->dynamics().energy();
    sum.kinetic += part.kinetic;
    sum.potential += part.potential;
  }
  return sum;
}

namespace {

void check_size(const char* what, std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw UsageError(std::string(what) + ": found " + std::to_string(found) + " numbers, expected " +
                   std::to_string(expected));
}

}  // namespace

Simulation::Simulation(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::initialize(double time, double tolerance) {
  Impl& s = *impl_;
  if (!std::isfinite(time)) throw UsageError("the start time is not a finite number");
  s.time = time;
  s.u.start(time);
  s.initialized = false;
  s.prepared = prepare(s.scene, s.reduced);
  s.make_islands();
  s.find_independent();
  for (const auto& island : s.islands) island->start_integrator(tolerance);
  s.initialized = true;
}

void Simulation::step_to(double end) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a step before initialize()");
  if (!std::isfinite(end)) throw UsageError("the end of a step is not a finite number");
  if (end < s.time) {
    throw UsageError(at_time(end) + "lies before the plant's time " + std::to_string(s.time) + " s");
  }
  if (end <= s.time) return;
  s.check_inputs(end);
  s.advance(end);
}

void Simulation::exchange(Record& record) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a record of a run before initialize()");
  record.exchange(s.time);
  s.u.exchange(record);
  for (const auto& island : s.islands) island->exchange(record);
}

double Simulation::time() const { return impl_->time; }
const Scene& Simulation::scene() const { return impl_->scene; }
const ModelSize& Simulation::size() const { return impl_->size; }
const std::vector<Signal>& Simulation::inputs() const { return impl_->inputs; }
const std::vector<Signal>& Simulation::outputs() const { return impl_->outputs; }
const std::vector<Signal>& Simulation::diagnostics() const { return impl_->diagnostics; }
const std::vector<int>& Simulation::independent_coordinates() const { return impl_->independent; }
const std::vector<StateVariable>& Simulation::states() const { return impl_->states; }
std::string Simulation::assembly_report() const { return impl_->prepared.report; }
const PreparedScene& Simulation::prepared() const { return impl_->prepared; }

double Simulation::last_singular_position() const {
  double last = -std::numeric_limits<double>::infinity();
  for (const auto& island : impl_->islands) last = std::max(last, island->last_singular_position());
  return last;
}

Equations& Simulation::equations(int island) {
  if (!impl_->initialized) throw UsageError("equations before initialize()");
  return impl_->islands.at(island)->equations();
}

const std::vector<double>& Simulation::state(int island) const { return impl_->islands.at(island)->state(); }

double Simulation::evaluation_cost() {
  if (!impl_->initialized) throw UsageError("a measurement before initialize()");
  double sum = 0;
  const double budget = std::max(4e-4, 0.02 / static_cast<double>(std::max<std::size_t>(1, impl_->islands.size())));
  for (const auto& island : impl_->islands) sum += island->evaluation_cost(budget);
  return sum;
}

void Simulation::set_input(int index, double value) {
  Impl& s = *impl_;
  if (!std::isfinite(value))
    throw UsageError(s.inputs.at(index).name + ": found " + std::to_string(value) +
                     ", expected a finite number; the former value stays");
  const Inputs::Change change = s.u.set(s.known_input(index), value);
  if (change == Inputs::Change::none || !s.initialized) return;
  if (const int island = s.island_of_input[index]; island >= 0) {
    s.islands[island]->inputs_changed(change == Inputs::Change::jump);
  }
}

void Simulation::set_input_derivative(int index, int order, double value) {
  Impl& s = *impl_;
  const std::string& name = s.inputs.at(index).name;
  if (order < 1 || order > Inputs::highest_order) {
    throw UsageError(name + ": found a derivative of order " + std::to_string(order) + ", expected one of order 1 to " +
                     std::to_string(Inputs::highest_order));
  }
  if (!std::isfinite(value)) {
    throw UsageError(name + ": found " + std::to_string(value) + " for its derivative of order " +
                     std::to_string(order) + ", expected a finite number; the former value stays");
  }
  s.u.set_derivative(index, order, value);
}

void Simulation::tune(const Scene& scene) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("tuning before initialize()");
  take_tunables(s.scene, scene);
  s.load_maker->fill(s.other_loads);
  for (std::size_t i = 0; i < s.islands.size(); ++i) s.islands[i]->swap_loads(s.other_loads[i]);
  s.still_energy = standing_energy(s.scene, s.prepared.reduced);
}

double Simulation::input(int index) const { return impl_->u.value(impl_->known_input(index)); }

double Simulation::input_derivative(int index, int order) const {
  if (order < 1 || order > Inputs::highest_order) throw UsageError("a derivative is of order 1 to 5");
  return impl_->u.derivative(impl_->known_input(index), order);
}

double Simulation::output(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("an output before initialize()");
  if (const int part = s.readings->energy_part(index); part >= 0) {
    const Energy e = s.energy();
    return part == 0 ? e.kinetic : part == 1 ? e.potential : e.kinetic + e.potential;
  }
  if (s.readings->island(index) < 0) return s.readings->constant(index);
  Island& island = *s.islands[s.readings->island(index)];
  island.refresh(s.readings->needs(index));
  return s.readings->value(index, island.reading());
}

void Simulation::take_states(const std::vector<int>& independent_coordinates) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("states before initialize()");
  if (s.independent == independent_coordinates) return;
  for (const int q : independent_coordinates) {
    const Signal& signal = s.outputs.at(q);
    const bool of_tree = signal.level == 0 && s.prepared.reduced.joints[signal.joint].role == JointPlace::Role::tree;
    if (!of_tree) throw UsageError(signal.name + " is no state: its joint closes a loop or cannot move");
  }
  s.sensitivity.reset();
  s.independent = independent_coordinates;
  s.states = states_behind(s.scene, s.outputs, s.independent);
  for (int i = 0; i < static_cast<int>(s.islands.size()); ++i) {
    const std::vector<bool> wanted = speeds_behind(s.prepared.reduced, s.outputs, i, s.states);
    std::vector<int> all;
    for (int k = 0; k < static_cast<int>(wanted.size()); ++k) {
      if (wanted[k]) all.push_back(k);
    }
    // Beside them may stand turns of a quaternion that is no state as a whole.
    const std::vector<int> found = s.independent_of(i, wanted);
    s.independent_by_island[i] = std::ranges::includes(found, all) ? found : all;
  }
}

template <class Ask>
auto Simulation::differentiate(Ask ask) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a derivative before initialize()");
  if (!s.sensitivity) {
    s.sensitivity = std::make_unique<Sensitivity>(s.prepared.reduced, s.islands, *s.readings, s.outputs, s.states,
                                                  s.independent_by_island, s.u.now());
  }
  try {
    s.u.go_to(s.time);
    return ask(*s.sensitivity);
  } catch (const Undetermined& fault) {
    throw NotDifferentiable(
        describe_undetermined(fault.reason(), s.time, s.names_of_coordinates(s.sensitivity->faulty_island())));
  } catch (const SingularMass& fault) {
    throw NotDifferentiable(describe_lost_inertia(s.time, fault.what()));
  }
}

Linearization Simulation::linearize() {
  return differentiate([](Sensitivity& s) { return s.linearize(); });
}

Slope Simulation::slope_along(const std::vector<double>& dx, const std::vector<double>& du) {
  check_size("dx", dx.size(), impl_->states.size());
  check_size("du", du.size(), impl_->u.count());
  return differentiate([&](Sensitivity& s) { return s.along(dx, du); });
}

Eigen::MatrixX2d Simulation::output_derivatives(const std::vector<double>& udot, const std::vector<double>& uddot) {
  const Inputs& u = impl_->u;
  const auto known = [&](const char* name, const std::vector<double>& given, int order) {
    if (!given.empty()) check_size(name, given.size(), u.count());
    std::vector<double> rates(given);
    for (auto i = static_cast<int>(given.size()); i < static_cast<int>(u.count()); ++i) {
      rates.push_back(u.derivative_at(i, order, impl_->time));
    }
    return rates;
  };
  const std::vector<double> first = known("udot", udot, 1);
  const std::vector<double> second = known("uddot", uddot, 2);
  return differentiate([&](Sensitivity& s) { return s.in_time(first, second); });
}

double Simulation::diagnostic(int index) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a diagnostic before initialize()");
  const auto total = [&](long (Island::*count)() const) {
    long sum = 0;
    for (const auto& island : s.islands) sum += ((*island).*count)();
    return static_cast<double>(sum);
  };
  const auto largest = [&](double (Island::*gap)() const) {
    double most = 0;
    for (const auto& island : s.islands) {
      island->refresh(Outputs::Needs::velocities);
      most = std::max(most, ((*island).*gap)());
    }
    return most;
  };
  switch (static_cast<Diagnostic>(index)) {
    case Diagnostic::steps:
      return total(&Island::steps);
    case Diagnostic::rejected_steps:
      return total(&Island::rejected_steps);
    case Diagnostic::jacobians:
      return total(&Island::jacobians);
    case Diagnostic::singular_positions:
      return total(&Island::singular_positions);
    case Diagnostic::evaluations:
      return total(&Island::evaluations);
    case Diagnostic::constraint_position:
      return largest(&Island::position_gap);
    case Diagnostic::constraint_velocity:
      return largest(&Island::velocity_gap);
    case Diagnostic::kinetic_energy:
      return s.energy().kinetic;
    case Diagnostic::potential_energy:
      return s.energy().potential;
    case Diagnostic::total_energy:
      break;
  }
  const Energy energy = s.energy();
  return energy.kinetic + energy.potential;
}

}  // namespace gelenk
