// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/preparation.h"

#include <algorithm>

#include "scene/text.h"
#include "simulation/report.h"
#include "simulation/start.h"

namespace gelenk {
namespace {

struct Preparer {
  const Scene& scene;
  PreparedScene out{};
  std::vector<Loads> loads{};
  std::vector<std::unique_ptr<Dynamics>> dynamics{};

  // Closes the loops of all islands. wished: the scene whose start values count.
  void assemble_islands(const Scene& wished) {
    const ReducedScene& reduced = out.reduced;
    out.islands.clear();
    dynamics.clear();
    loads = make_loads(scene, reduced);
    for (int i = 0; i < static_cast<int>(reduced.islands.size()); ++i) {
      const Mechanism& mechanism = reduced.islands[i];
      PreparedIsland& island = out.islands.emplace_back();
      dynamics.push_back(make_dynamics(mechanism, loads[i]));
      const StartWishes wishes = start_wishes(wished, reduced, i);
      island.cut_start = wishes.cuts.q;
      try {
        island.start = assemble(mechanism, *dynamics[i], wishes.tree, wishes.cuts);
        dynamics[i]->normalise(island.start.q.data());
        dynamics[i]->set_position(island.start.q.data());
        dynamics[i]->factorise();  // tells parts that move without inertia
      } catch (const CannotAssemble& fault) {
        throw AssemblyError(describe_failure(scene, reduced, i, fault));
      } catch (const SingularMass& fault) {
        throw SceneError({describe_massless(scene, fault.what())});
      }
    }
  }

  void find_structure() {
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      PreparedIsland& island = out.islands[i];
      island.structure = structure_of(out.reduced.islands[i], *dynamics[i], island.start.q);
    }
  }

  bool reaction_observed(const Mechanism& mechanism) const {
    return std::ranges::any_of(scene.sensors, [&](const Sensor& sensor) {
      return sensor.type == SensorType::reaction &&
             std::ranges::any_of(mechanism.joints, [&](int j) { return scene.joints[j].name == sensor.joint; });
    });
  }

  // Joints that loops hold still, with their coordinates; empty if there are none.
  StandingJoints standing_joints() const {
    StandingJoints standing(scene.joints.size());
    bool any = false;
    for (std::size_t i = 0; i < out.islands.size(); ++i) {
      const Mechanism& mechanism = out.reduced.islands[i];
      const Structure& structure = out.islands[i].structure;
      // What holds still is held by forces; where these are read, all stays as it is.
      if (reaction_observed(mechanism)) continue;
      for (const int j : mechanism.joints) {
        const JointPlace& place = out.reduced.joints[j];
        const bool tree = place.role == JointPlace::Role::tree;
        if (!(tree ? structure.standing_links : structure.standing_cuts)[place.index]) continue;
        standing[j] = coordinates_of(scene, out.reduced, j, out.islands[i].start.q, *dynamics[i]);
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
        wish.q = coordinates_of(scene, out.reduced, j, start.q, *dynamics[i]);
        wish.q_given.assign(wish.q.size(), true);
        const JointPlace& place = out.reduced.joints[j];
        std::vector<double> v(wish.v.size() + 6);
        if (place.role == JointPlace::Role::tree) {
          std::copy_n(start.v.begin() + place.iv, wish.v.size(), v.begin());
        } else {
          dynamics[i]->cut_speeds(place.index, v.data());
        }
        for (std::size_t k = 0; k < wish.v.size(); ++k) wish.v[k] = place.v_sign[k] * v[k];
        wish.v_given.assign(wish.v.size(), true);
      }
    }
    return at;
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

PreparedScene prepare(const Scene& scene, const ReducedScene& reduced) {
  Preparer preparer{.scene = scene};
  PreparedScene& out = preparer.out;
  out.reduced = reduced;
  preparer.assemble_islands(scene);
  preparer.find_structure();
  std::vector<Assembled> starts;
  for (const PreparedIsland& island : out.islands) starts.push_back(island.start);
  out.report = describe_assembly(scene, out.reduced, starts);
  if (scene.solver.reduces(Reduction::fixed)) {
    if (const StandingJoints standing = preparer.standing_joints(); !standing.empty()) {
      const Scene found = preparer.found();
      out.reduced = reduce(scene, standing);
      preparer.assemble_islands(found);
      preparer.find_structure();
    }
  }
  preparer.drop_rows();
  return std::move(preparer.out);
}

}  // namespace gelenk
