// SPDX-License-Identifier: BSD-3-Clause
// Initialization and tuning of a simulation. Separate from the code that every step executes, since it is compiled for
// small size.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "integrator/controlled_steps.h"
#include "preparation/loads.h"
#include "preparation/report.h"
#include "scene/settable.h"
#include "scene/shapes.h"
#include "simulation/parameters.h"
#include "simulation/simulation_impl.h"

namespace gelenk {
namespace {

// Whether input `i` is a time derivative of the input before it.
bool continues_motion(const std::vector<Signal>& signals, std::size_t i) {
  return i < signals.size() && signals[i].name.ends_with("_ref") && signals[i].group > 0;
}

}  // namespace

ModelSize size_of(const ReducedScene& reduced) {
  ModelSize size;
  for (const Mechanism& mechanism : reduced.islands) {
    size.bodies += static_cast<int>(mechanism.links.size()) - 1;
    size.coordinates += mechanism.nq;
    size.speeds += mechanism.nv;
    size.rows += mechanism.rows;
    size.element_states += static_cast<int>(mechanism.states.size());
    size.planar_islands += mechanism.planar ? 1 : 0;
  }
  size.islands = static_cast<int>(reduced.islands.size());
  size.planar = size.planar_islands == size.islands;
  return size;
}

const Inputs& Simulation::Impl::inputs_at_start(const std::vector<Signal>& signals, Inputs& u) {
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (signals[i].name.ends_with("_ref") && !continues_motion(signals, i)) {
      std::size_t last = i;
      while (continues_motion(signals, last + 1)) ++last;
      u.add_motion(static_cast<int>(i), static_cast<int>(last - i));
    }
    u.set(static_cast<int>(i), signals[i].start);
  }
  return u;
}

void Simulation::Impl::make_islands() {
  size = size_of(prepared.reduced);
  load_assembler.emplace(scene, prepared.reduced);
  std::vector<Loads> loads;
  for (std::vector<Loads>* of : {&loads, &other_loads}) load_assembler->fill(*of);
  sensitivity.reset();
  islands.clear();
  islands_of_input.assign(u.signals(), {});
  islands_showing_input = islands_of_input;
  size.rows = 0;
  for (std::size_t i = 0; i < prepared.islands.size(); ++i) {
    islands.push_back(std::make_unique<Island>(scene, prepared.islands[i], std::move(loads[i]), u, time));
    const auto add = [&](std::vector<std::vector<int>>& islands_of, int input) {
      if (input < 0 || input >= static_cast<int>(u.signals()))
        return;  // an element state, what is named of the motion, a force
      std::vector<int>& of = islands_of[static_cast<std::size_t>(input)];
      if (of.empty() || of.back() != static_cast<int>(i)) of.push_back(static_cast<int>(i));
    };
    for (const int input : islands[i]->loads().inputs) add(islands_of_input, input);
    for (const Formula& value : islands[i]->loads().values) {
      for (const int input : value.signals()) add(islands_showing_input, input);
    }
    const PreparedIsland& of = islands[i]->prepared();
    size.rows += of.mechanism.rows;
    size.rank += of.mobility.rank;
    size.free_coordinates += of.mechanism.nv - of.mobility.position_rank;
  }
  size.degrees_of_freedom = size.speeds - size.rank;
  std::vector<std::vector<SwitchingForce>> switching_forces;
  for (const auto& island : islands) switching_forces.push_back(switching_forces_of(island->loads()));
  readings = std::make_unique<Outputs>(scene, prepared.reduced, outputs, switching_forces);
  for (std::size_t i = 0; i < islands.size(); ++i) islands[i]->read_forces(*readings, static_cast<int>(i));
  immobile_energy = gelenk::immobile_energy(scene, prepared.reduced);
}

Simulation::Simulation(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::assemble(double time) {
  Impl& s = *impl_;
  if (!std::isfinite(time)) throw UsageError("the start time is not a finite number");
  s.time = time;
  s.u.start(time);
  s.initialized = s.runs = false;
  s.prepare_start();
  s.make_islands();
  s.find_independent();
  if (s.scene.solver.start == "equilibrium") s.start_at_equilibrium();
  std::vector<std::string> violated;
  for (const auto& island : s.islands) {
    std::ranges::move(describe_violated_limits(s.scene, island->loads(), island->dynamics(), island->reading().q),
                      std::back_inserter(violated));
    std::ranges::move(
        describe_violated_swings(s.scene, island->prepared().mechanism, island->dynamics(), island->reading().q),
        std::back_inserter(violated));
    const int unstoppable = island->formulation().modes().locks().state().unstoppable;
    if (unstoppable >= 0 && !island->prepared().mechanism.driven())  // inputs that prescribe motions may still change
      violated.push_back(describe_unstoppable(s.scene, island->loads(), unstoppable));
  }
  if (!violated.empty()) throw SceneError(violated);
  s.initialized = true;
}

void Simulation::initialize(double time, double tolerance) {
  assemble(time);
  Impl& s = *impl_;
  s.initialized = false;
  const double wanted = tolerance > 0 ? tolerance : s.scene.experiment.tolerance;
  double finest = 0;
  for (const auto& island : s.islands) {
    island->start_integrator(wanted);
    if (const Integrator* made = island->integrator()) finest = std::max(finest, made->finest_tolerance());
  }
  const bool may_step = std::ranges::any_of(s.islands, [](const auto& island) {
    return island->integrator() != nullptr && island->formulation().contacts().are_required();
  });
  const bool chooses = s.scene.solver.integrator.empty() || s.scene.solver.integrator == "auto";
  if (const std::string reason = chooses && may_step ? reason_for_time_steps(s.scene) : ""; !reason.empty())
    s.prepared.warnings.push_back(describe_time_steps(s.scene, reason, accuracy_of_steps(wanted)));
  if (wanted < finest)
    s.prepared.warnings.push_back(describe_unreachable_tolerance(s.scene.solver.integrator, wanted, finest));
  if (any_integrator(s.islands, &Integrator::may_have_history)) s.log.reserve();
  s.initialized = s.runs = true;
  s.worst_step = 0;
}

void Simulation::tune(const Scene& scene) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("parameters cannot be tuned before initialize()");
  take_tunables(s.given, scene);
  if (s.scene.units.is_si()) {
    take_tunables(s.scene, scene);
  } else {
    s.tuned = s.given;
    convert(s.tuned, s.scene.units);
    take_tunables(s.scene, s.tuned);
  }
  s.load_assembler->fill(s.other_loads);
  for (std::size_t i = 0; i < s.islands.size(); ++i) s.islands[i]->swap_loads(s.other_loads[i]);
  s.immobile_energy = gelenk::immobile_energy(s.scene, s.prepared.reduced);
}

}  // namespace gelenk
