// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/repeated_start.h"

#include <algorithm>
#include <utility>

#include "preparation/repeated_analysis.h"
#include "preparation/report.h"
#include "scene/settable.h"
#include "scene/touching_laws.h"
#include "simulation/simulation_impl.h"

namespace gelenk {

struct RepeatedStart::Kept {
  explicit Kept(const Inputs& u) : inputs(u) {}

  Inputs inputs;                 // as of a new simulation
  std::vector<Archive> islands;  // each in the state in which it begins
  std::optional<RepeatedAnalysis> analysis;
  double time = 0;
};

RepeatedStart::RepeatedStart(Simulation& simulation)
    : simulation_(simulation), kept_(std::make_unique<Kept>(simulation.impl_->u)) {}
RepeatedStart::~RepeatedStart() = default;

void RepeatedStart::keep() {
  Simulation::Impl& s = *simulation_.impl_;
  // What happens at the start itself would be counted again.
  const bool nothing_happened =
      std::ranges::all_of(s.islands, [](const auto& of) { return of->events().count() == 0; });
  const bool plain = s.moved.empty() && s.scene.solver.start != "equilibrium" && !has_touching_laws(s.scene) &&
                     s.scene.solver.integrator != "moreau-jean" && nothing_happened;
  if (!plain) return;
  std::vector<const Loads*> loads;
  for (const auto& island : s.islands) loads.push_back(&island->loads());
  kept_->time = s.time;
  kept_->analysis.emplace(s.scene, s.time, s.u, s.prepared, s.reduced, loads);
  if (!kept_->analysis->is_possible()) return kept_->analysis.reset();
  for (const auto& island : s.islands) island->serialize(kept_->islands.emplace_back());
}

bool RepeatedStart::is_possible() const { return kept_->analysis.has_value(); }

bool RepeatedStart::begin(const std::function<bool(Scene&)>& change, const std::function<void()>& set_inputs) {
  Simulation::Impl& s = *simulation_.impl_;
  s.initialized = s.runs = false;
  if (!change(s.given) || !take_numbers()) return false;
  s.u = kept_->inputs;
  set_inputs();
  s.time = kept_->time;
  s.u.start(s.time);
  if (!take_loads() || !kept_->analysis->repeat()) return false;
  begin_islands();
  if (!starts_within_limits()) return false;
  Archive none{std::vector<std::uint64_t>()};
  s.log.serialize(none, 0);
  s.cut_short = false;
  s.worst_step = 0;
  s.initialized = s.runs = true;
  return true;
}

// Brings those of the scene in natural units up to date; returns false if these units change.
bool RepeatedStart::take_numbers() {
  Simulation::Impl& s = *simulation_.impl_;
  const UnitSystem units = natural_units(s.given);
  if (units.length != s.scene.units.length || units.mass != s.scene.units.mass) return false;
  const Scene* from = &s.given;
  if (!units.is_si()) {
    s.tuned = s.given;
    convert(s.tuned, units);
    from = &s.tuned;
  }
  take_tunables(s.scene, *from);
  for (std::size_t b = 0; b < from->bodies.size(); ++b) {
    Body& to = s.scene.bodies[b];
    to.mass = from->bodies[b].mass;
    to.com = from->bodies[b].com;
    to.inertia = from->bodies[b].inertia;
  }
  s.immobile_energy = immobile_energy(s.scene, s.prepared.reduced);
  return true;
}

bool RepeatedStart::take_loads() {
  Simulation::Impl& s = *simulation_.impl_;
  s.load_assembler->fill(s.other_loads);
  for (std::size_t i = 0; i < s.islands.size(); ++i) {
    if (!differ_in_numbers_alone(s.islands[i]->loads(), s.other_loads[i])) return false;
  }
  for (std::size_t i = 0; i < s.islands.size(); ++i) s.islands[i]->renew_loads(s.other_loads[i]);
  return true;
}

void RepeatedStart::begin_islands() {
  const Simulation::Impl& s = *simulation_.impl_;
  for (std::size_t i = 0; i < s.islands.size(); ++i) {
    s.islands[i]->begin_again(kept_->islands[i], s.prepared.reduced.islands[i], s.prepared.islands[i].mobility);
  }
}

// A run that does not is refused in words by a new simulation.
bool RepeatedStart::starts_within_limits() const {
  const Simulation::Impl& s = *simulation_.impl_;
  return std::ranges::all_of(s.islands, [&](const auto& island) {
    return describe_violated_limits(s.scene, island->loads(), island->dynamics(), island->reading().q).empty() &&
           island->formulation().modes().locks().state().unstoppable < 0;
  });
}

void Island::begin_again(Archive& initial, const Mechanism& like, const MobilityAnalysis& mobility) {
  for (std::size_t k = 0; k < like.links.size(); ++k) prepared_.mechanism.links[k].G = like.links[k].G;
  prepared_.mobility = mobility;
  best_pivot_ratio_ = mobility.known_pivot_ratio();
  dynamics_->loads_changed();
  program_.loads_changed();
  initial.start_reading();
  serialize(initial);
  equations_->start(prepared_.cut_start, time_, y_.data());
  if (!integrator_) return;
  record_equations();
  integrator_->restart(time_, y_.data());
  evaluations_before_ = dynamics_->evaluations();
  // As after the trial step of a new island: what its method would keep from one step to the next is that of a restart.
  Archive& here = replay_.beginning;
  here.start_writing();
  serialize(here);
  here.start_reading();
  serialize(here);
}

}  // namespace gelenk
