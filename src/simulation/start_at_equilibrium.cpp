// SPDX-License-Identifier: BSD-3-Clause
// Start at an equilibrium instead of at the start values, and what keeps a position at rest.
#include <utility>

#include "analysis/equilibrium.h"
#include "preparation/report.h"
#include "preparation/rest_forces.h"
#include "scene/natural_time.h"
#include "simulation/simulation_impl.h"

namespace gelenk {

EquilibriumProblem Simulation::Impl::at_rest(const Island& island,
                                             const std::vector<MotionLaw::Derivatives>& targets) const {
  const PreparedIsland& of = island.prepared();
  return {of.mechanism, island.loads(), of.mobility, u.now(), targets, natural_time(given, scene.units)};
}

// Islands are treated one by one: they are not coupled.
void Simulation::Impl::start_at_equilibrium() {
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const Island& island = *islands[i];
    const Mechanism& mechanism = island.prepared().mechanism;
    const std::vector<MotionLaw::Derivatives> targets = island.targets();
    for (std::size_t row = 0; row < targets.size(); ++row) {
      if (targets[row][1] == 0) continue;
      throw AssemblyError(describe_moving_drive(scene, mechanism.coordinate_rows[row].constraint));
    }
    Assembled& start = prepared.islands[i].start;
    try {
      Equilibrium rest =
          find_equilibrium(at_rest(island, targets), start.q, island.formulation().revolutions().coordinates());
      start.q = std::move(rest.q);
      prepared.islands[i].cut_start = std::move(rest.cut_q);
    } catch (const NoEquilibrium& fault) {
      throw AssemblyError(describe_no_equilibrium(scene, prepared.reduced, static_cast<int>(i),
                                                  independent_by_island[i].speeds, fault.left));
    } catch (const NotDifferentiablePoint& fault) {
      throw AssemblyError(describe_undetermined(scene, fault, time, names_of_coordinates(static_cast<int>(i))));
    }
    start.v.assign(start.v.size(), 0.0);
  }
  make_islands();
  find_independent();
}

RestForces Simulation::rest_forces() {
  if (!impl_->initialized) throw UsageError("forces at rest before initialize()");
  impl_->u.go_to(impl_->time);
  RestForces out;
  for (const auto& island : impl_->islands) {
    const std::vector<MotionLaw::Derivatives> targets = island->targets();
    const double* q = island->reading().q;
    out.add(impl_->scene, impl_->at_rest(*island, targets), {q, q + island->prepared().mechanism.nq},
            island->formulation().revolutions().coordinates());
  }
  return out;
}

}  // namespace gelenk
