// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/preparation.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include "analysis/singular_start.h"
#include "dynamics/collapsed_spring.h"
#include "formulation/targets.h"
#include "scene/text.h"
#include "simulation/report.h"
#include "simulation/signals.h"
#include "simulation/start.h"

namespace gelenk {
namespace {

bool has_rods(const ReducedScene& reduced) {
  return std::ranges::any_of(reduced.joints, [](const JointPlace& j) { return j.role == JointPlace::Role::rod; });
}

// For what is only kinematics: nothing in it moves without inertia.
void give_inertia(ReducedScene& reduced) {
  for (Mechanism& mechanism : reduced.islands) {
    for (Link& link : mechanism.links) {
      link.G = Spatial::Inertia::about_com(1, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
    }
  }
}

Scene without_rods(const Scene& scene) {
  Scene out = scene;
  out.solver.reductions[static_cast<std::size_t>(Reduction::massless)] = false;
  return out;
}

struct Preparer {
  const Scene& scene;
  double time;
  const Inputs& inputs;
  Scene wished{};            // the scene whose start values count
  bool rods_as_rows = true;  // as far as the scene allows
  std::vector<double> no_inputs = std::vector<double>(input_signals(scene).size(), 0.0);
  PreparedScene out{};
  std::vector<Loads> loads{};
  std::vector<std::unique_ptr<Dynamics>> dynamics{};

  // Closes the loops of all islands of `reduced`, as near to the wishes as can be.
  void assemble_islands(ReducedScene made) {
    out.reduced = std::move(made);
    const ReducedScene& reduced = out.reduced;
    out.islands.clear();
    dynamics.clear();
    loads = make_loads(scene, reduced);
    for (int i = 0; i < static_cast<int>(reduced.islands.size()); ++i) {
      const Mechanism& mechanism = reduced.islands[i];
      PreparedIsland& island = out.islands.emplace_back();
      dynamics.push_back(make_dynamics(mechanism, loads[i]));
      dynamics[i]->set_targets(Targets(mechanism).at(time, inputs));
      const StartWishes wishes = start_wishes(wished, reduced, i);
      island.cut_start = wishes.cuts.q;
      try {
        island.start = assemble(mechanism, *dynamics[i], wishes.tree, wishes.cuts);
        dynamics[i]->normalise(island.start.q.data());
        dynamics[i]->set_position(island.start.q.data());
        check_wheels(mechanism, *dynamics[i]);
        dynamics[i]->factorise();  // tells parts that move without inertia
      } catch (const CannotAssemble& fault) {
        throw AssemblyError(describe_failure(scene, reduced, i, fault));
      } catch (const SingularMass& fault) {
        throw SceneError({describe_massless(scene, fault.what())});
      }
    }
  }

  void check_wheels(const Mechanism& mechanism, const Dynamics& of) const {
    for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
      const Cut& cut = mechanism.cuts[c];
      if (lies_flat(cut.joint, of.cut_pose(c))) throw AssemblyError(describe_flat_wheel(scene, cut.constraint));
    }
  }

  // The start is looked for while the rods are still bodies: so wishes at their joints count, and it is the same with
  // and without this reduction.
  void assemble_with_rods(const ReducedScene& reduced) {
    assemble_islands(reduce_to_geometry(scene));
    tell_assembly();
    wished = found();
    std::exception_ptr singular;
    try {
      assemble_islands(reduced);
      return;
    } catch (const SceneError&) {
      singular = std::current_exception();
    }
    // A neighbour may have had its inertia from beyond the rod.
    wished = scene;
    rods_as_rows = false;
    try {
      assemble_islands(reduce(basis()));
    } catch (const SceneError&) {
      std::rethrow_exception(singular);
    }
  }

  // The scene with the switches of what is left to do.
  Scene basis() const { return rods_as_rows ? scene : without_rods(scene); }

  void tell_assembly() {
    std::vector<Assembled> starts;
    for (const PreparedIsland& island : out.islands) starts.push_back(island.start);
    out.report = describe_assembly(scene, out.reduced, starts);
  }

  // Goes to other positions, too, where a part may come to move without inertia.
  void find_structure() {
    try {
      explore();
    } catch (const SingularMass& fault) {
      throw SceneError({describe_massless(scene, fault.what())});
    }
  }

  void explore() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      PreparedIsland& island = out.islands[i];
      const Mechanism& mechanism = out.reduced.islands[i];
      const std::vector<double>& q = island.start.q;
      if (!mechanism.driven()) {
        island.structure = structure_of(mechanism, *dynamics[i], q, way(island, *dynamics[i]));
        continue;
      }
      const Mechanism free_mechanism = without_drives(mechanism);
      const auto free = make_dynamics(free_mechanism, loads[i]);
      free->set_targets(Targets(free_mechanism).at(time, inputs));
      island.structure =
          driven_structure_of(mechanism, *dynamics[i], free_mechanism, *free, q, way(island, *dynamics[i]));
    }
  }

  // The motion with which an island sets out: its speeds, or from rest its accelerations without inputs.
  std::vector<double> way(const PreparedIsland& island, Dynamics& of) const {
    const auto moves = [](const std::vector<double>& v) {
      return std::ranges::any_of(v, [](double x) { return std::abs(x) > 1e-9; });
    };
    if (moves(island.start.v)) return island.start.v;
    std::vector<double> vdot(island.start.v.size());
    of.set_position(island.start.q.data());
    of.factorise();
    of.set_velocity(island.start.v.data());
    of.solve(no_inputs.data(), vdot.data());
    return moves(vdot) ? vdot : std::vector<double>();
  }

  bool reaction_observed(const Mechanism& mechanism) const {
    return std::ranges::any_of(scene.sensors, [&](const Sensor& sensor) {
      return sensor.type == SensorType::reaction &&
             std::ranges::any_of(mechanism.joints, [&](int j) { return scene.joints[j].name == sensor.joint; });
    });
  }

  // Constraints have their forces as outputs.
  static bool reads_forces(const Mechanism& mechanism) {
    return !mechanism.coordinate_rows.empty() ||
           std::ranges::any_of(mechanism.cuts, [](const Cut& cut) { return cut.is_contact(); });
  }

  // Joints that loops hold still, with their coordinates; empty if there are none.
  StandingJoints standing_joints() const {
    StandingJoints standing(scene.joints.size());
    bool any = false;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const Mechanism& mechanism = out.reduced.islands[i];
      const Structure& structure = out.islands[i].structure;
      // What holds still is held by forces; where these are read, all stays as it is.
      if (reaction_observed(mechanism) || reads_forces(mechanism)) continue;
      for (const int j : mechanism.joints) {
        const JointPlace& place = out.reduced.joints[j];
        const bool tree = place.role == JointPlace::Role::tree;
        if (!(tree ? structure.standing_links : structure.standing_cuts)[place.index]) continue;
        standing[j] = coordinates_of(wished, out.reduced, j, out.islands[i].start.q, *dynamics[i]);
        any = true;
      }
    }
    return any ? standing : StandingJoints();
  }

  // The scene with the positions and speeds found as its wishes.
  Scene found() const {
    Scene at = scene;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const Assembled& start = out.islands[i].start;
      dynamics[i]->set_velocity(start.v.data());
      for (const int j : out.reduced.islands[i].joints) {
        JointStart& wish = at.joints[j].start;
        wish.q = coordinates_of(wished, out.reduced, j, start.q, *dynamics[i]);
        wish.q_given.assign(wish.q.size(), true);
        const JointPlace& place = out.reduced.joints[j];
        double of_cut[max_cut_nv];
        const double* v = start.v.data() + place.iv;
        if (place.role != JointPlace::Role::tree) {
          dynamics[i]->cut_speeds(place.index, of_cut);
          v = of_cut + place.iv - out.reduced.islands[i].cuts[place.index].iv;
        }
        for (std::size_t k = 0; k < wish.v.size(); ++k) wish.v[k] = place.v_sign[k] * v[k];
        wish.v_given.assign(wish.v.size(), true);
      }
    }
    return at;
  }

  // Velocities at singular starts, and warnings of these.
  void examine_starts() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const int island = static_cast<int>(i);
      const Mechanism& mechanism = out.reduced.islands[i];
      const StartWishes wishes = start_wishes(wished, out.reduced, island);
      PreparedIsland& of = out.islands[i];
      const SingularStart found =
          examine_start(mechanism, *dynamics[i], of.structure, wishes.tree, wishes.cuts, of.start);
      if (!found.on_branch) throw AssemblyError(describe_no_branch(scene, out.reduced, island, found));
      if (found.share < doubtful_share) {
        out.warnings.push_back(describe_singular_start(scene, out.reduced, island, found));
      }
      dynamics[i]->set_position(of.start.q.data());
      dynamics[i]->set_root_poses();
      const int force = collapsed_spring(loads[i], *dynamics[i]);
      if (force >= 0) out.warnings.push_back(describe_collapsed_spring(scene, force));
    }
  }

  void drop_rows() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      PreparedIsland& island = out.islands[i];
      const bool drop = scene.solver.reduces(Reduction::redundant_rows);
      island.mechanism = drop ? with_rows(out.reduced.islands[i], island.structure.needed) : out.reduced.islands[i];
    }
  }
};

}  // namespace

ReducedScene reduce_to_geometry(const Scene& scene) {
  ReducedScene out = reduce(without_rods(scene));
  give_inertia(out);
  return out;
}

PreparedScene prepare(const Scene& scene, const ReducedScene& reduced, double time, const Inputs& inputs) {
  Preparer preparer{.scene = scene, .time = time, .inputs = inputs, .wished = scene};
  if (has_rods(reduced)) {
    preparer.assemble_with_rods(reduced);
  } else {
    preparer.assemble_islands(reduced);
    preparer.tell_assembly();
  }
  preparer.find_structure();
  if (scene.solver.reduces(Reduction::fixed)) {
    if (const StandingJoints standing = preparer.standing_joints(); !standing.empty()) {
      preparer.wished = preparer.found();
      preparer.assemble_islands(reduce(preparer.basis(), standing));
      preparer.find_structure();
    }
  }
  preparer.examine_starts();
  preparer.drop_rows();
  return std::move(preparer.out);
}

}  // namespace gelenk
