// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/preparation.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "analysis/singular_start.h"
#include "dynamics/undefined_force.h"
#include "formulation/targets.h"
#include "mechanism/graph.h"
#include "preparation/inertia.h"
#include "preparation/report.h"
#include "preparation/start.h"
#include "scene/signals.h"
#include "util/text.h"

namespace gelenk {
namespace {

// m or rad: loops that gape by more do so for another reason than rounded numbers.
constexpr double rounded_gap = 0.1;

// Of the mechanism's length: loops that gape by more at the start do so because their equations contradict each other.
constexpr double rounding = 1e-12;
// A pivot below this share of the largest may be what rounded numbers have left of one that was zero.
constexpr double nearly_singular = 1e-2;

bool is_doubtful(const PreparedIsland& island) {
  const MobilityAnalysis& mobility = island.mobility;
  const auto stands = [&](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
  const bool sound = std::isfinite(mobility.best_pivot_ratio) && mobility.best_pivot_ratio >= nearly_singular;
  const bool barely = !sound && mobility.needed_rows > 0;
  return island.start.gap > rounding || mobility.stuck || (barely && stands(mobility.immobile_links));
}

// What dynamics refer to.
struct Stage {
  ReducedScene reduced;
  std::vector<Loads> loads;
};

// Whether an island is done is its own affair: what others need leaves it as it would be alone, to the bit.
struct Preparer {
  const Scene& scene;
  double time;
  const Inputs& inputs;
  Scene preferred{};                     // the scene whose start values count
  std::vector<bool> rods_stay_bodies{};  // by joint of the scene: in its island; none: nowhere
  bool rows_help = true;                 // where the mass matrix alone is singular
  std::vector<double> no_inputs = std::vector<double>(input_signals(scene).size(), 0.0);
  PreparedScene out{};
  std::vector<Loads> loads{};
  std::vector<std::unique_ptr<Dynamics>> dynamics{};
  std::vector<std::unique_ptr<Stage>> former{};  // to which dynamics that were kept refer

  static constexpr int anew = -1;

  // Goes on with other islands. same: by island, the one so far that it is, which keeps all it has, or `anew`; empty:
  // all are.
  void take_islands(ReducedScene made, const std::vector<int>& same = {}) {
    former.push_back(std::make_unique<Stage>(Stage{std::move(out.reduced), std::move(loads)}));
    std::vector<PreparedIsland> islands = std::exchange(out.islands, {});
    std::vector<std::unique_ptr<Dynamics>> kept = std::exchange(dynamics, {});
    out.reduced = std::move(made);
    loads = make_loads(scene, out.reduced);
    for (std::size_t i = 0; i < out.reduced.islands.size(); ++i) {
      if (same.empty() || same[i] == anew) {
        out.islands.emplace_back();
        dynamics.push_back(make_moving_dynamics(out.reduced.islands[i], static_cast<int>(i)));
        continue;
      }
      out.islands.push_back(std::move(islands[same[i]]));
      dynamics.push_back(std::move(kept[same[i]]));
      out.reduced.islands[i].mass_needs_rows = former.back()->reduced.islands[same[i]].mass_needs_rows;
    }
  }

  // Closes the loops of an island, as near to the wishes as can be.
  void close(int i) {
    try {
      assemble_island(i);
    } catch (const CannotAssemble& fault) {
      const std::string what = describe_failure(scene, out.reduced, i, fault);
      // Velocities that fail although none is fixed do so because rows contradict each other.
      const bool loop = fault.cut < 0 ? fault.conflict.values.empty()
                                      : fault.cut < static_cast<int>(out.reduced.islands[i].cuts.size());
      if (loop && fault.gap + fault.turn < rounded_gap) throw OpenLoop(what, fault.gap + fault.turn);
      throw AssemblyError(what);
    } catch (const SingularMass& fault) {
      throw SceneError({describe_massless(scene, fault.what())});
    }
  }

  void assemble_islands(ReducedScene made, const std::vector<int>& same = {}) {
    take_islands(std::move(made), same);
    for (int i = 0; i < static_cast<int>(out.islands.size()); ++i) {
      if (same.empty() || same[i] == anew) close(i);
    }
  }

  // With the rows that change with time where they are at the start.
  std::unique_ptr<Dynamics> make_moving_dynamics(const Mechanism& mechanism, int island) const {
    auto of = make_dynamics(mechanism, loads[island]);
    of->set_targets(Targets(mechanism).at(time, inputs));
    return of;
  }

  // Throws CannotAssemble, SingularMass.
  void assemble_island(int i) {
    const Mechanism& mechanism = out.reduced.islands[i];
    const StartGuesses guesses = start_guesses(preferred, out.reduced, i);
    PreparedIsland& island = out.islands[i];
    island.cut_start = guesses.cuts.q;
    try {
      island.start = assemble(mechanism, *dynamics[i], guesses.tree, guesses.cuts);
      stand_at_start(i);
    } catch (const SingularMass&) {
      if (mechanism.rows == 0 || !rows_help) throw;
      Mechanism geometry = mechanism;
      give_inertia(geometry);
      island.start = assemble(geometry, *make_moving_dynamics(geometry, i), guesses.tree, guesses.cuts);
      let_rows_help(i);
    }
    if (mechanism.mass_needs_rows || mechanism.rows == 0 || !rows_help) return;
    if (!lacks_inertia(mechanism) || dynamics[i]->mass_is_definite()) return;
    let_rows_help(i);  // what stands for inertia is rounding
  }

  // Tells parts that move without inertia.
  void stand_at_start(int i) {
    std::vector<double>& q = out.islands[i].start.q;
    dynamics[i]->normalize(q.data());
    dynamics[i]->set_position(q.data());
    check_rows(out.reduced.islands[i], *dynamics[i]);
    dynamics[i]->factorize();
  }

  void let_rows_help(int i) {
    Mechanism& mechanism = out.reduced.islands[i];
    mechanism.mass_needs_rows = true;
    dynamics[i] = make_moving_dynamics(mechanism, i);
    stand_at_start(i);
  }

  void check_rows(const Mechanism& mechanism, const Dynamics& of) const {
    for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
      const Cut& cut = mechanism.cuts[c];
      if (is_undefined(cut.joint, of.cut_pose(c))) throw AssemblyError(describe_undefined_rows(scene, cut));
    }
  }

  // The start is looked for while the rods are still bodies: so wishes at their joints count, and it is the same with
  // and without this reduction.
  void assemble_with_rods(const ReducedScene& reduced) {
    const std::vector<bool> with_rods = islands_with_rods(reduced);
    ReducedScene geometry = reduce_to_geometry(scene);
    for (std::size_t i = 0; i < with_rods.size(); ++i) {
      if (!with_rods[i]) geometry.islands[i] = reduced.islands[i];
    }
    assemble_islands(std::move(geometry));
    tell_assembly();
    const Scene near = found(with_rods);
    rods_stay_bodies.assign(scene.joints.size(), false);
    std::vector<Attempt> attempts(with_rods.size());
    std::vector<int> same;  // of those that are done
    for (std::size_t i = 0; i < with_rods.size(); ++i) same.push_back(with_rods[i] ? anew : static_cast<int>(i));
    do {
      for (std::size_t i = 0; i < same.size(); ++i) {
        if (same[i] == anew) choose(reduced.islands[i], attempts[i].number, near);
      }
      take_islands(reduce(scene, {}, rods_stay_bodies), same);
      for (int i = 0; i < static_cast<int>(same.size()); ++i) {
        if (same[i] == anew && closes(i, attempts[i])) same[i] = i;
      }
    } while (std::ranges::find(same, anew) != same.end());
    rows_help = true;
  }

  struct Attempt {
    int number = 0;
    std::exception_ptr first_fault;
  };

  // Throws the first fault when the last attempt fails.
  bool closes(int island, Attempt& attempt) {
    try {
      rows_help = attempt.number >= 2;
      close(island);
      return true;
    } catch (const SceneError&) {
      if (!attempt.first_fault) attempt.first_fault = std::current_exception();
      if (++attempt.number == 4) std::rethrow_exception(attempt.first_fault);
      return false;
    }
  }

  // Every other attempt leaves the rods bodies: a neighbour may have had its inertia from beyond the rod.
  void choose(const Mechanism& mechanism, int attempt, const Scene& near) {
    const bool rods = attempt % 2 == 0;
    for (const int j : mechanism.joints) {
      rods_stay_bodies[j] = !rods;
      preferred.joints[j].start = (rods ? near : scene).joints[j].start;
    }
  }

  void tell_assembly() {
    std::vector<Assembled> starts;
    for (const PreparedIsland& island : out.islands) starts.push_back(island.start);
    out.report = describe_assembly(scene, out.reduced, starts);
    for (int i = 0; i < static_cast<int>(starts.size()); ++i) {
      if (!starts[i].equal_q.empty()) tell_equal_assemblies(i, starts[i]);
    }
  }

  // By the coordinate in which the two differ most.
  void tell_equal_assemblies(int island, const Assembled& start) {
    double most = -1;
    std::string name;
    double taken = 0;
    double other = 0;
    for (const int j : out.reduced.islands[island].joints) {
      if (out.reduced.joints[j].role != JointPlace::Role::tree) continue;
      const JointKind& kind = *find_joint_kind(scene.joints[j].type);
      const std::vector<double> a = coordinates_of(preferred, out.reduced, j, start.q, *dynamics[island]);
      const std::vector<double> b = coordinates_of(preferred, out.reduced, j, start.equal_q, *dynamics[island]);
      for (std::size_t k = 0; k < a.size(); ++k) {
        if (std::abs(a[k] - b[k]) <= most) continue;
        most = std::abs(a[k] - b[k]);
        const double size = scene.units.size_of(kind.q[k].unit);
        name = scene.joints[j].name + "." + std::string(kind.q[k].name);
        taken = size * a[k];
        other = size * b[k];
      }
    }
    out.warnings.push_back(describe_equal_assemblies(scene, name, taken, other));
  }

  // Goes to other positions, too, where a part may come to move without inertia. same: as above.
  void find_structure(const std::vector<int>& same = {}) {
    try {
      for (std::size_t i = 0; i < out.islands.size(); ++i) {
        if (same.empty() || same[i] == anew) explore(i);
      }
    } catch (const SingularMass& fault) {
      throw SceneError({describe_massless(scene, fault.what())});
    }
  }

  void explore(std::size_t i) {
    PreparedIsland& island = out.islands[i];
    const Mechanism& mechanism = out.reduced.islands[i];
    const std::vector<double>& q = island.start.q;
    if (!mechanism.driven()) {
      island.mobility = analyze_mobility(mechanism, *dynamics[i], q, way(island, *dynamics[i]));
      return;
    }
    Mechanism free_mechanism = without_drives(mechanism);
    if (mechanism.mass_needs_rows) give_inertia(free_mechanism);  // the drive may be what holds a part without any
    const auto free = make_dynamics(free_mechanism, loads[i]);
    free->set_targets(Targets(free_mechanism).at(time, inputs));
    island.mobility =
        analyze_driven_mobility(mechanism, *dynamics[i], free_mechanism, *free, q, way(island, *dynamics[i]));
  }

  // The motion with which an island sets out: its speeds, or from rest its accelerations without inputs.
  std::vector<double> way(const PreparedIsland& island, Dynamics& of) const {
    const auto moves = [](const std::vector<double>& v) {
      return std::ranges::any_of(v, [](double x) { return std::abs(x) > 1e-9; });
    };
    if (moves(island.start.v)) return island.start.v;
    std::vector<double> vdot(island.start.v.size());
    of.set_position(island.start.q.data());
    of.factorize();
    of.set_velocity(island.start.v.data());
    of.solve(no_inputs.data(), vdot.data());
    return moves(vdot) ? vdot : std::vector<double>();
  }

  bool reaction_observed(const Mechanism& mechanism) const {
    return std::ranges::any_of(scene.sensors, [&](const Sensor& sensor) {
      return kind_of(sensor.is).reads_reaction && std::ranges::any_of(mechanism.joints, [&](int j) {
               return scene.joints[j].name == sensor.joints.front();
             });
    });
  }

  // Constraints have their forces as outputs.
  static bool reads_forces(const Mechanism& mechanism) {
    return !mechanism.coordinate_rows.empty() ||
           std::ranges::any_of(mechanism.cuts, [](const Cut& cut) { return cut.is_contact(); });
  }

  // Joints that loops hold still, with their coordinates; empty if there are none.
  ImmobileJoints immobile_joints() const {
    ImmobileJoints immobile(scene.joints.size());
    bool any = false;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const Mechanism& mechanism = out.reduced.islands[i];
      const MobilityAnalysis& mobility = out.islands[i].mobility;
      // What holds still is held by forces; where these are read, all stays as it is.
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

  // What loops hold still becomes part of the ground, and the rest of these islands is assembled anew.
  void drop_standing(const ImmobileJoints& immobile) {
    std::vector<bool> changed;
    for (const Mechanism& mechanism : out.reduced.islands) {
      changed.push_back(std::ranges::any_of(mechanism.joints, [&](int j) { return !immobile[j].empty(); }));
    }
    preferred = found(changed);
    ReducedScene made = reduce(scene, immobile, rods_stay_bodies);
    std::vector<int> same;
    for (const Mechanism& mechanism : made.islands) {
      const int before = mechanism.joints.empty() ? anew : out.reduced.joints[mechanism.joints.front()].island;
      same.push_back(before == anew || changed[before] ? anew : before);
    }
    assemble_islands(std::move(made), same);
    find_structure(same);
  }

  // The wishes, and in these islands the positions and speeds found.
  Scene found(const std::vector<bool>& islands) const {
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

  // Velocities at singular starts, and warnings of these.
  void examine_starts() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const int island = static_cast<int>(i);
      const Mechanism& mechanism = out.reduced.islands[i];
      const StartGuesses guesses = start_guesses(preferred, out.reduced, island);
      PreparedIsland& of = out.islands[i];
      const SingularStart found =
          examine_start(mechanism, *dynamics[i], of.mobility, guesses.tree, guesses.cuts, of.start);
      if (!found.on_branch) throw AssemblyError(describe_no_branch(scene, out.reduced, island, found));
      if (found.share < doubtful_fraction) {
        out.warnings.push_back(describe_singular_start(scene, out.reduced, island, found));
      }
      dynamics[i]->set_position(of.start.q.data());
      dynamics[i]->readings().set_root_poses();
      const int force = undefined_force(loads[i], dynamics[i]->readings());
      if (force >= 0) out.warnings.push_back(describe_collapsed_spring(scene, force));
    }
  }

  void drop_rows() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      PreparedIsland& island = out.islands[i];
      const bool drop = scene.solver.reduces(Reduction::redundant_rows);
      island.mechanism = drop ? with_rows(out.reduced.islands[i], island.mobility.needed) : out.reduced.islands[i];
    }
  }
};

}  // namespace

PreparedScene prepare(const Scene& scene, const ReducedScene& reduced, double time, const Inputs& inputs, bool asking) {
  Preparer preparer{.scene = scene, .time = time, .inputs = inputs, .preferred = scene};
  if (has_rods(reduced)) {
    preparer.assemble_with_rods(reduced);
  } else {
    preparer.assemble_islands(reduced);
    preparer.tell_assembly();
  }
  preparer.find_structure();
  preparer.out.doubtful = std::ranges::any_of(preparer.out.islands, is_doubtful);
  if (asking && preparer.out.doubtful) return std::move(preparer.out);
  if (scene.solver.reduces(Reduction::fixed)) {
    if (const ImmobileJoints immobile = preparer.immobile_joints(); !immobile.empty()) preparer.drop_standing(immobile);
  }
  preparer.examine_starts();
  preparer.drop_rows();
  return std::move(preparer.out);
}

}  // namespace gelenk
