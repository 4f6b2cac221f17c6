// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/assemblies.h"

#include <algorithm>

#include "formulation/targets.h"
#include "kinematics/loads.h"
#include "preparation/adjustment.h"
#include "preparation/loads.h"
#include "preparation/preparation.h"
#include "preparation/report.h"
#include "preparation/start.h"
#include "scene/formulas.h"
#include "simulation/simulation.h"

namespace gelenk {
namespace {

AssemblyPart in_user_coordinates(const Scene& scene, const ReducedScene& reduced, int island, Dynamics& dynamics,
                                 const Branches& branches) {
  AssemblyPart out;
  out.joints = reduced.islands[island].joints;
  out.starts = branches.starts;
  out.closed = branches.closed;
  out.settled = branches.settled;
  for (const Branch& branch : branches.found) {
    Assembly& assembly = out.assemblies.emplace_back();
    dynamics.set_position(branch.q.data());
    for (const int j : out.joints) {
      std::vector<double>& q = assembly.q.emplace_back(coordinates_of(scene, reduced, j, branch.q, dynamics));
      const JointKind& kind = *find_joint_kind(scene.joints[j].type);
      for (int i = 0; i < kind.nq; ++i) q[i] *= scene.units.size_of(kind.q[i].unit);
    }
    assembly.distance = branch.distance;
    assembly.degrees_of_freedom = branch.degrees_of_freedom;
    assembly.hits = branch.hits;
    assembly.chosen = branch.is_default;
    assembly.flat = branch.is_not_isolated;
  }
  return out;
}

std::vector<int> links_of(const Scene& scene, const ReducedScene& reduced, int island,
                          const std::vector<std::string>& bodies) {
  std::vector<int> out;
  for (const std::string& name : bodies) {
    const auto body = std::ranges::find(scene.bodies, name, &Body::name);
    const BodyPlace& place = reduced.bodies[static_cast<std::size_t>(body - scene.bodies.begin())];
    if (place.island == island) out.push_back(place.link);
  }
  return out;
}

}  // namespace

std::vector<AssemblyPart> list_assemblies(const Scene& scene, const std::vector<std::string>& bodies, int most_starts,
                                          unsigned seed) {
  Scene natural = scene;
  convert(natural, natural_units(scene));
  if (natural.assembly.tolerance > 0) natural = adjust(natural, natural.assembly.tolerance).scene;
  for (const std::string& name : bodies) {
    if (std::ranges::find(scene.bodies, name, &Body::name) == scene.bodies.end()) {
      throw UsageError(name + ": no such body");
    }
  }
  const ReducedScene reduced = reduce_to_geometry(natural);
  const std::vector<Loads> loads = make_loads(natural, reduced);
  const Inputs no_inputs(input_signals(scene).size(), reads_time(scene));
  std::vector<AssemblyPart> out;
  for (int i = 0; i < static_cast<int>(reduced.islands.size()); ++i) {
    const Mechanism& mechanism = reduced.islands[i];
    if (mechanism.rows == 0) continue;
    const Search search{.max_starts = most_starts, .seed = seed, .links = links_of(scene, reduced, i, bodies)};
    if (!bodies.empty() && search.links.empty()) continue;
    const auto dynamics = make_dynamics(mechanism, loads[i]);
    const std::vector<double> signals = signals_at_start(natural, mechanism, no_inputs);
    dynamics->set_targets(Targets(mechanism, loads[i]).at(0, no_inputs, signals.data()));
    const StartGuesses guesses = start_guesses(natural, reduced, i);
    try {
      const Branches branches = find_branches(mechanism, *dynamics, guesses.tree, guesses.cuts, search);
      out.push_back(in_user_coordinates(natural, reduced, i, *dynamics, branches));
    } catch (const CannotAssemble& fault) {
      throw AssemblyError(describe_failure(natural, reduced, i, fault));
    }
  }
  return out;
}

}  // namespace gelenk
