// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/repeated_analysis.h"

#include <algorithm>
#include <utility>

#include "analysis/singular_start.h"
#include "formulation/targets.h"
#include "math/bitwise.h"
#include "mechanism/graph.h"
#include "preparation/inertia.h"
#include "preparation/initial_direction.h"

namespace gelenk {
namespace {

// Whether the positions of an island are those of joints and loops alone, and its mass matrix is regular by itself.
bool is_plain(const Mechanism& mechanism) {
  return !mechanism.driven() && !mechanism.mass_needs_rows && !mechanism.touches() &&
         std::ranges::none_of(mechanism.cuts, [](const Cut& cut) { return cut.is_rod() || cut.opens_beside; });
}

// Whether joints were found to be immobile, and merged.
bool has_merged(const ReducedScene& reduced) {
  return std::ranges::any_of(reduced.joints, [](const JointPlace& place) { return !place.q.empty(); });
}

// All that was found of which the reductions and the equations follow.
bool is_same_structure(const MobilityAnalysis& a, const MobilityAnalysis& b) {
  return a.rank == b.rank && a.rank_start == b.rank_start && a.position_rank == b.position_rank && a.stuck == b.stuck &&
         a.needed == b.needed && a.needed_rows == b.needed_rows && a.immobile_links == b.immobile_links &&
         a.immobile_cuts == b.immobile_cuts;
}

template <class Lists>
std::vector<std::size_t> sizes(const Lists& lists) {
  std::vector<std::size_t> out;
  each_list(lists, [&](const auto& list) { out.push_back(list.size()); });
  return out;
}

}  // namespace

RepeatedAnalysis::RepeatedAnalysis(const Scene& scene, double time, const Inputs& inputs, PreparedScene& prepared,
                                   const ReducedScene& before, const std::vector<const Loads*>& loads)
    : scene_(scene), prepared_(prepared), loads_(loads), no_inputs_(without_inputs(inputs, scene.states.size(), time)) {
  const ReducedScene& reduced = prepared.reduced;
  is_possible_ = !prepared.doubtful && prepared.warnings.empty() && !has_rods(before) && !has_rods(reduced) &&
                 !has_merged(reduced) && std::ranges::all_of(reduced.islands, is_plain) && find_bodies();
  if (!is_possible_) return;
  for (std::size_t i = 0; i < reduced.islands.size(); ++i) {
    const Mechanism& mechanism = reduced.islands[i];
    guesses_.push_back(start_guesses(scene, reduced, static_cast<int>(i)));
    dynamics_.push_back(make_dynamics(mechanism, *loads_[i]));
    dynamics_.back()->set_targets(
        Targets(mechanism, *loads_[i]).at(time, inputs, signals_at_start(scene, mechanism, inputs).data()));
    if (!dynamics_.back()->switching_forces().loads().empty()) is_possible_ = false;
  }
}

// Returns false where the inertia of a link is not the sum over its bodies that is formed here, in any bit.
bool RepeatedAnalysis::find_bodies() {
  std::vector<Note> notes;
  const Graph graph = partition_of(scene_, {}, notes).whole;
  const ReducedScene& reduced = prepared_.reduced;
  std::size_t count = 0;
  for (const Mechanism& mechanism : reduced.islands) count += mechanism.links.size() - 1;
  for (const Group& group : graph.groups) {
    if (&group == &graph.groups.front() || group.bodies.empty()) continue;
    const BodyPlace& place = reduced.bodies[static_cast<std::size_t>(group.bodies.front())];
    if (place.island < 0 || place.rod >= 0) return false;
    const Bodies& of = links_.emplace_back(Bodies{place.island, place.link, group.bodies, group.X_GB, place.X_LB});
    const Mechanism& mechanism = reduced.islands[static_cast<std::size_t>(of.island)];
    if (!is_bitwise_equal(inertia(of), mechanism.links[static_cast<std::size_t>(of.link)].G)) return false;
  }
  return links_.size() == count;
}

Spatial::Inertia RepeatedAnalysis::inertia(const Bodies& of) const {
  Spatial::Inertia sum;
  for (std::size_t i = 0; i < of.bodies.size(); ++i) {
    const Body& body = scene_.bodies[static_cast<std::size_t>(of.bodies[i])];
    sum += Spatial::Inertia::about_com(body.mass, body.com, body.inertia).moved_by(of.X_GB[i]);
  }
  return sum.moved_by(of.X_LG);
}

bool RepeatedAnalysis::repeat() {
  for (const Bodies& of : links_) {
    Mechanism& mechanism = prepared_.reduced.islands[static_cast<std::size_t>(of.island)];
    mechanism.links[static_cast<std::size_t>(of.link)].G = inertia(of);
  }
  for (std::size_t i = 0; i < dynamics_.size(); ++i) {
    if (!repeat(i)) return false;
  }
  return true;
}

bool RepeatedAnalysis::repeat(std::size_t island) try {
  const Mechanism& mechanism = prepared_.reduced.islands[island];
  PreparedIsland& of = prepared_.islands[island];
  Dynamics& dynamics = *dynamics_[island];
  dynamics.loads_changed();
  dynamics.set_position(of.start.q.data());
  dynamics.factorize();
  if (lacks_inertia(mechanism) && !dynamics.link_without_inertia().empty()) return false;
  MobilityAnalysis found =
      analyze_mobility(mechanism, dynamics, of.start.q, initial_direction(of.start, dynamics, no_inputs_.data()));
  if (!is_same_structure(found, of.mobility)) return false;
  of.mobility = std::move(found);
  if (is_doubtful(of)) return false;
  // At a singular start, velocities are chosen and a warning is given.
  Assembled start = of.start;
  const StartGuesses& guesses = guesses_[island];
  const SingularStart at = examine_start(mechanism, dynamics, of.mobility, guesses.tree, guesses.cuts, start);
  if (!at.on_branch || at.pivot_fraction <= doubtful_fraction) return false;
  dynamics.set_position(of.start.q.data());
  dynamics.readings().set_root_poses();
  return undefined_force(*loads_[island]->forces, dynamics.readings()) < 0;
} catch (const SingularMass&) {
  return false;
}

bool differ_in_numbers_alone(const Loads& a, const Loads& b) {
  const auto same = [](const JointLoads& x, const JointLoads& y) { return sizes(x.lists) == sizes(y.lists); };
  return same(a.tree, b.tree) && std::ranges::equal(a.cuts, b.cuts, same) && a.inputs == b.inputs &&
         a.only_along_tree == b.only_along_tree && a.named.size() == b.named.size() &&
         links_of(*a.forces).size() == links_of(*b.forces).size();
}

}  // namespace gelenk
