// SPDX-License-Identifier: BSD-3-Clause
// Start at an equilibrium instead of at the start values.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/equilibrium.h"
#include "preparation/report.h"
#include "scene/natural_time.h"
#include "simulation/simulation_impl.h"

namespace gelenk {

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
      Equilibrium rest = find_equilibrium({.mechanism = mechanism,
                                           .loads = island.loads(),
                                           .mobility = island.prepared().mobility,
                                           .u = u.now(),
                                           .targets = targets,
                                           .time = natural_time(given, scene.units)},
                                          start.q, island.formulation().revolutions().coordinates());
      start.q = std::move(rest.q);
      prepared.islands[i].cut_start = std::move(rest.cut_q);
    } catch (const NoEquilibrium& fault) {
      const std::vector<int>& speeds = independent_by_island[i].speeds;
      const auto size = [&](int k) { return std::abs(fault.left[k]); };
      const int worst = *std::ranges::max_element(speeds, {}, size);
      throw AssemblyError(
          describe_no_equilibrium(scene, prepared.reduced, static_cast<int>(i), worst, fault.left[worst]));
    } catch (const NotDifferentiablePoint& fault) {
      throw AssemblyError(describe_undetermined(scene, fault, time, names_of_coordinates(static_cast<int>(i))));
    }
    start.v.assign(start.v.size(), 0.0);
  }
  make_islands();
  find_independent();
}

}  // namespace gelenk
