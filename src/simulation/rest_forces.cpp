// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/rest_forces.h"

#include "analysis/equilibrium.h"
#include "scene/element_numbers.h"
#include "scene/natural_time.h"
#include "simulation/simulation_impl.h"

namespace gelenk {

RestForces find_rest_forces(Simulation& of) {
  Simulation::Impl& s = *of.impl_;
  if (!s.initialized) throw UsageError("forces at rest before initialize()");
  s.u.go_to(s.time);
  RestForces out{.coordinates = {}, .is_balanced = true, .is_held = true};
  for (const auto& at : s.islands) {
    Island& island = *at;
    const Mechanism& mechanism = island.prepared().mechanism;
    const std::vector<MotionLaw::Derivatives> targets = island.targets();
    const double* q = island.reading().q;
    const HoldingForces found =
        find_holding_forces({.mechanism = mechanism,
                             .loads = island.loads(),
                             .mobility = island.prepared().mobility,
                             .u = s.u.now(),
                             .targets = targets,
                             .time = natural_time(s.given, s.scene.units)},
                            {q, q + mechanism.nq}, island.formulation().revolutions().coordinates());
    out.is_balanced = out.is_balanced && found.is_balanced;
    out.is_held = out.is_held && found.is_held;
    const std::vector<IndicatorText> texts = indicator_texts(island.loads());
    const Branching& forces = island.dynamics().branching();
    for (int i = 0; i < forces.locks(); ++i) {
      const Branching::Lock lock = forces.lock(i);
      const IndicatorText& text = texts[2 * static_cast<std::size_t>(lock.friction >= 0 ? lock.friction : lock.limit)];
      const Joint& joint = s.scene.joints[static_cast<std::size_t>(text.joint)];
      const Coordinate coordinate = coordinate_of(kind_of(joint.is), text.component);
      const std::string unit = unit_of("{f}", coordinate);
      const double size = s.scene.units.size_of(unit);
      const HoldingForces::Of& force = found.coordinates[static_cast<std::size_t>(i)];
      out.coordinates.push_back({.coordinate = joint.name + "." + std::string(coordinate.name),
                                 .unit = unit,
                                 .force = size * force.force,
                                 .limit = size * force.limit,
                                 .side = force.side});
    }
  }
  return out;
}

}  // namespace gelenk
