// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/preparation.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "analysis/singular_start.h"
#include "formulation/targets.h"
#include "mechanism/graph.h"
#include "preparation/doubts.h"
#include "preparation/friction_loads.h"
#include "preparation/inertia.h"
#include "preparation/initial_direction.h"
#include "preparation/loads.h"
#include "preparation/report.h"
#include "preparation/start.h"
#include "scene/formulas.h"
#include "scene/signals.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Larger closure errors [m or rad, natural units] have other causes than rounded dimensions.
constexpr double max_rounded_closure_error = 0.1;
// Larger closure errors at the start [natural units] show that the constraint equations are inconsistent.
constexpr double max_closure_error = 1e-12;
// A smaller ratio of pivots may belong to a pivot that would be zero without rounded dimensions.
constexpr double suspect_pivot_ratio = 1e-2;

// Data that Dynamics refers to.
struct ReducedModel {
  ReducedScene reduced;
  std::vector<Loads> loads;
};

// Islands are assembled independently: the result for an island is the same, bit for bit, as if it were alone.
struct Preparer {
  const Scene& scene;
  double time;
  const Inputs& inputs;
  Scene preferred{};                     // the scene with the start values to be used
  std::vector<bool> rods_stay_bodies{};  // by joint of the scene: in its island; empty: in none
  bool mass_may_need_rows = true;        // constraint rows may complete a singular mass matrix
  std::vector<double> no_inputs = without_inputs(inputs, scene.states.size(), time);
  PreparedScene out{};
  std::vector<Loads> loads{};
  std::vector<std::unique_ptr<Dynamics>> dynamics{};
  std::vector<std::unique_ptr<ReducedModel>> previous_models{};  // referred to by kept dynamics

  static constexpr int reassemble = -1;

  // Replaces the islands. kept: for each one the previous island to be kept, or `reassemble`; empty: reassemble all.
  void replace_islands(ReducedScene made, const std::vector<int>& kept = {}) {
    previous_models.push_back(std::make_unique<ReducedModel>(ReducedModel{std::move(out.reduced), std::move(loads)}));
    std::vector<PreparedIsland> islands = std::exchange(out.islands, {});
    std::vector<std::unique_ptr<Dynamics>> kept_dynamics = std::exchange(dynamics, {});
    out.reduced = std::move(made);
    loads = make_loads(scene, out.reduced);
    for (std::size_t i = 0; i < out.reduced.islands.size(); ++i) {
      if (kept.empty() || kept[i] == reassemble) {
        out.islands.emplace_back();
        dynamics.push_back(make_moving_dynamics(out.reduced.islands[i], static_cast<int>(i)));
        continue;
      }
      out.islands.push_back(std::move(islands[kept[i]]));
      dynamics.push_back(std::move(kept_dynamics[kept[i]]));
      out.reduced.islands[i].mass_needs_rows = previous_models.back()->reduced.islands[kept[i]].mass_needs_rows;
    }
  }

  // Closes the loops of an island, as close to the initial guesses as possible.
  void close(int i) {
    try {
      assemble_island(i);
    } catch (const CannotAssemble& fault) {
      if (fault.cut >= 0) {  // from where its equations are undefined nothing can be closed
        dynamics[i]->set_position(fault.q.data());
        check_rows_are_defined(out.reduced.islands[i], *dynamics[i]);
      }
      const std::string what = describe_failure(scene, out.reduced, i, fault);
      // If velocities cannot be found although none is fixed, the constraint equations are inconsistent.
      const bool loop = fault.cut < 0 ? fault.conflict.values.empty()
                                      : fault.cut < static_cast<int>(out.reduced.islands[i].cuts.size());
      if (loop && fault.gap + fault.turn < max_rounded_closure_error) throw OpenLoop(what, fault.gap + fault.turn);
      throw AssemblyError(what);
    } catch (const SingularMass& fault) {
      throw SceneError({describe_massless(scene, fault.what())});
    }
  }

  void assemble_islands(ReducedScene made, const std::vector<int>& kept = {}) {
    replace_islands(std::move(made), kept);
    for (int i = 0; i < static_cast<int>(out.islands.size()); ++i) {
      if (kept.empty() || kept[i] == reassemble) close(i);
    }
  }

  // Creates dynamics with time-dependent constraint equations evaluated at the start.
  std::unique_ptr<Dynamics> make_moving_dynamics(const Mechanism& mechanism, int island) const {
    auto of = make_dynamics(mechanism, loads[island]);
    of->set_targets(
        Targets(mechanism, loads[island]).at(time, inputs, signals_at_start(scene, mechanism, inputs).data()));
    return of;
  }

  // Throws CannotAssemble, SingularMass.
  void assemble_island(int i) {
    const Mechanism& mechanism = out.reduced.islands[i];
    check_prescribed_motions(scene, mechanism, time);
    const StartGuesses guesses = start_guesses(preferred, out.reduced, i);
    check_relations(scene, mechanism, guesses.tree.q);
    PreparedIsland& island = out.islands[i];
    island.cut_start = guesses.cuts.q;
    try {
      island.start = assemble(mechanism, *dynamics[i], guesses.tree, guesses.cuts);
      evaluate_at_start(i);
    } catch (const SingularMass&) {
      if (mechanism.rows == 0 || !mass_may_need_rows) throw;
      Mechanism geometry = mechanism;
      give_inertia(geometry);
      island.start = assemble(geometry, *make_moving_dynamics(geometry, i), guesses.tree, guesses.cuts);
      include_rows_in_mass(i);
    }
    if (mechanism.mass_needs_rows || !lacks_inertia(mechanism)) return;
    if (mechanism.rows > 0 && !mass_may_need_rows) return;
    const std::string massless = dynamics[i]->link_without_inertia();
    if (massless.empty()) return;
    if (mechanism.rows == 0) throw SingularMass(massless);
    include_rows_in_mass(i);  // the inertia is only round-off
  }

  // Throws SingularMass for parts that move without inertia.
  void evaluate_at_start(int i) {
    std::vector<double>& q = out.islands[i].start.q;
    dynamics[i]->normalize(q.data());
    dynamics[i]->set_position(q.data());
    check_rows_are_defined(out.reduced.islands[i], *dynamics[i]);
    dynamics[i]->factorize();
  }

  void include_rows_in_mass(int i) {
    Mechanism& mechanism = out.reduced.islands[i];
    mechanism.mass_needs_rows = true;
    dynamics[i] = make_moving_dynamics(mechanism, i);
    evaluate_at_start(i);
  }

  void check_rows_are_defined(const Mechanism& mechanism, const Dynamics& of) const {
    for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
      const Cut& cut = mechanism.cuts[c];
      if (is_undefined(*cut.joint, of.cut_pose(c))) throw AssemblyError(describe_undefined_rows(scene, cut));
    }
  }

  // Assembles with rods as bodies, so that guesses of their joints count and the reduction does not change the start.
  void assemble_with_rods(const ReducedScene& reduced) {
    const std::vector<bool> with_rods = islands_with_rods(reduced);
    ReducedScene geometry = reduce_to_geometry(scene);
    for (std::size_t i = 0; i < with_rods.size(); ++i) {
      if (!with_rods[i]) geometry.islands[i] = reduced.islands[i];
    }
    assemble_islands(std::move(geometry));
    report_assembly();
    const Scene near = scene_at_start(with_rods);
    rods_stay_bodies.assign(scene.joints.size(), false);
    std::vector<Attempt> attempts(with_rods.size());
    std::vector<int> kept;  // of the islands that are done
    for (std::size_t i = 0; i < with_rods.size(); ++i) kept.push_back(with_rods[i] ? reassemble : static_cast<int>(i));
    do {
      for (std::size_t i = 0; i < kept.size(); ++i) {
        if (kept[i] == reassemble) choose_start(reduced.islands[i], attempts[i].number, near);
      }
      replace_islands(reduce(scene, {}, rods_stay_bodies), kept);
      for (int i = 0; i < static_cast<int>(kept.size()); ++i) {
        if (kept[i] == reassemble && closes(i, attempts[i])) kept[i] = i;
      }
    } while (std::ranges::find(kept, reassemble) != kept.end());
    mass_may_need_rows = true;
  }

  struct Attempt {
    int number = 0;
    std::exception_ptr first_fault;
  };

  // Returns false if the attempt failed; throws the first error if it was the last attempt.
  bool closes(int island, Attempt& attempt) {
    try {
      mass_may_need_rows = attempt.number >= 2;
      close(island);
      return true;
    } catch (const SceneError&) {
      if (!attempt.first_fault) attempt.first_fault = std::current_exception();
      if (++attempt.number == 4) std::rethrow_exception(attempt.first_fault);
      return false;
    }
  }

  // In every other attempt the rods remain bodies: a neighbor may depend on inertia beyond the rod.
  void choose_start(const Mechanism& mechanism, int attempt, const Scene& near) {
    const bool rods = attempt % 2 == 0;
    for (const int j : mechanism.joints) {
      rods_stay_bodies[j] = !rods;
      preferred.joints[j].start = (rods ? near : scene).joints[j].start;
    }
  }

  void report_assembly() {
    std::vector<Assembled> starts;
    for (const PreparedIsland& island : out.islands) starts.push_back(island.start);
    out.report = describe_assembly(scene, out.reduced, starts);
    for (int i = 0; i < static_cast<int>(starts.size()); ++i) {
      add_doubts(scene, out.reduced, i, starts[i], *dynamics[i], out.warnings);
    }
  }

  // Analyzes mobility, also at other positions, where a part may move without inertia. kept: as in replace_islands().
  void find_mobility(const std::vector<int>& kept = {}) {
    try {
      for (std::size_t i = 0; i < out.islands.size(); ++i) {
        if (kept.empty() || kept[i] == reassemble) analyze_island(i);
        check_loads_of_friction(scene, loads[i], out.reduced.islands[i], out.islands[i], *dynamics[i]);
      }
    } catch (const SingularMass& fault) {
      throw SceneError({describe_massless(scene, fault.what())});
    }
  }

  void analyze_island(std::size_t i) {
    PreparedIsland& island = out.islands[i];
    const Mechanism& mechanism = out.reduced.islands[i];
    if (!mechanism.driven()) {
      island.mobility = analyze_mobility(mechanism, *dynamics[i], island.start.q, direction(island, *dynamics[i]));
      return;
    }
    Mechanism free_mechanism = without_drives(mechanism);
    if (mechanism.mass_needs_rows) give_inertia(free_mechanism);  // the drive may hold a part without inertia
    const auto free = make_dynamics(free_mechanism, loads[i]);
    free->set_targets(
        Targets(free_mechanism, loads[i]).at(time, inputs, signals_at_start(scene, mechanism, inputs).data()));
    island.mobility = analyze_driven_mobility(mechanism, *dynamics[i], free_mechanism, *free, island.start.q,
                                              direction(island, *dynamics[i]));
  }

  std::vector<double> direction(const PreparedIsland& island, Dynamics& of) const {
    return initial_direction(island.start, of, no_inputs.data());
  }

  bool reaction_observed(const Mechanism& mechanism) const {
    return std::ranges::any_of(scene.sensors, [&](const Sensor& sensor) {
      return kind_of(*sensor.is).reads_reaction && std::ranges::any_of(mechanism.joints, [&](int j) {
               return scene.joints[j].name == sensor.joints.front();
             });
    });
  }

  // Returns true if the island has constraint elements, whose forces are outputs.
  static bool reads_forces(const Mechanism& mechanism) {
    return !mechanism.coordinate_rows.empty() ||
           std::ranges::any_of(mechanism.cuts, [](const Cut& cut) { return cut.is_contact(); });
  }

  // Returns the coordinates of joints that loops immobilize; empty if there are none.
  ImmobileJoints immobile_joints() const {
    ImmobileJoints immobile(scene.joints.size());
    bool any = false;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const Mechanism& mechanism = out.reduced.islands[i];
      const MobilityAnalysis& mobility = out.islands[i].mobility;
      // Forces on immobile joints are lost by this reduction, so it is skipped if forces are outputs.
      if (reaction_observed(mechanism) || reads_forces(mechanism)) continue;
      for (const int j : mechanism.joints) {
        const JointPlace& place = out.reduced.joints[j];
        const bool tree = place.role == JointPlace::Role::tree;
        if (!(tree ? mobility.immobile_links : mobility.immobile_cuts)[place.index]) continue;
        immobile[j] = coordinates_of(preferred, out.reduced, j, out.islands[i].start.q, *dynamics[i]);
        any = true;
      }
    }
    return any ? immobile : ImmobileJoints();
  }

  // Merges immobile joints with the ground, and assembles the rest of these islands again.
  void drop_immobile(const ImmobileJoints& immobile) {
    std::vector<bool> changed;
    for (const Mechanism& mechanism : out.reduced.islands) {
      changed.push_back(std::ranges::any_of(mechanism.joints, [&](int j) { return !immobile[j].empty(); }));
    }
    preferred = scene_at_start(changed);
    ReducedScene made = reduce(scene, immobile, rods_stay_bodies);
    std::vector<int> kept;
    for (const Mechanism& mechanism : made.islands) {
      const int before = mechanism.joints.empty() ? reassemble : out.reduced.joints[mechanism.joints.front()].island;
      kept.push_back(before == reassemble || changed[before] ? reassemble : before);
    }
    assemble_islands(std::move(made), kept);
    find_mobility(kept);
  }

  // Returns the scene with the positions and velocities found as start values in the given islands.
  Scene scene_at_start(const std::vector<bool>& islands) const {
    Scene at = preferred;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      if (!islands[i]) continue;
      const Assembled& start = out.islands[i].start;
      dynamics[i]->set_velocity(start.v.data());
      for (const int j : out.reduced.islands[i].joints) {
        JointStart& guess = at.joints[j].start;
        guess.q = coordinates_of(preferred, out.reduced, j, start.q, *dynamics[i]);
        guess.q_given.assign(guess.q.size(), true);
        guess.v = velocities_of(out.reduced, j, start.v, *dynamics[i]);
        guess.v_given.assign(guess.v.size(), true);
      }
    }
    return at;
  }

  // Corrects velocities at singular starts, and adds warnings about these and about springs of zero length.
  void examine_starts() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const int island = static_cast<int>(i);
      const Mechanism& mechanism = out.reduced.islands[i];
      const StartGuesses guesses = start_guesses(preferred, out.reduced, island);
      PreparedIsland& of = out.islands[i];
      const SingularStart found =
          examine_start(mechanism, *dynamics[i], of.mobility, guesses.tree, guesses.cuts, of.start);
      if (!found.on_branch) throw AssemblyError(describe_no_branch(scene, out.reduced, island, found));
      if (found.pivot_fraction < doubtful_fraction) {
        out.warnings.push_back(describe_singular_start(scene, out.reduced, island, found));
      }
      dynamics[i]->set_position(of.start.q.data());
      dynamics[i]->readings().set_root_poses();
      const int force = undefined_force(*loads[i].forces, dynamics[i]->readings());
      if (force >= 0) out.warnings.push_back(describe_collapsed_spring(scene, force));
    }
  }

  void remove_redundant_rows() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      PreparedIsland& island = out.islands[i];
      const bool drop = scene.solver.reduces(Reduction::redundant_rows);
      island.mechanism = drop ? with_rows(out.reduced.islands[i], island.mobility.needed) : out.reduced.islands[i];
      island.states = states_at_start(scene, island.mechanism);
    }
  }
};

}  // namespace

bool is_doubtful(const PreparedIsland& island) {
  const MobilityAnalysis& mobility = island.mobility;
  const auto any = [&](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
  const bool regular = std::isfinite(mobility.best_pivot_ratio) && mobility.best_pivot_ratio >= suspect_pivot_ratio;
  const bool nearly_singular = !regular && mobility.needed_rows > 0;
  return island.start.gap > max_closure_error || mobility.stuck || (nearly_singular && any(mobility.immobile_links));
}

PreparedScene prepare(const Scene& scene, const ReducedScene& reduced, double time, const Inputs& inputs,
                      bool stop_if_doubtful) {
  Preparer preparer{.scene = scene, .time = time, .inputs = inputs, .preferred = scene};
  if (has_rods(reduced)) {
    preparer.assemble_with_rods(reduced);
  } else {
    preparer.assemble_islands(reduced);
    preparer.report_assembly();
  }
  preparer.find_mobility();
  preparer.out.doubtful = std::ranges::any_of(preparer.out.islands, is_doubtful);
  if (stop_if_doubtful && preparer.out.doubtful) return std::move(preparer.out);
  if (scene.solver.reduces(Reduction::fixed)) {
    if (const ImmobileJoints immobile = preparer.immobile_joints(); !immobile.empty()) preparer.drop_immobile(immobile);
  }
  preparer.examine_starts();
  preparer.remove_redundant_rows();
  return std::move(preparer.out);
}

}  // namespace gelenk
