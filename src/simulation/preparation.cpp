// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/preparation.h"

#include <Eigen/Eigenvalues>
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
void give_inertia(Mechanism& mechanism) {
  mechanism.mass_needs_rows = false;
  for (Link& link : mechanism.links) {
    link.G = Spatial::Inertia::about_com(1, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  }
}

// Some link has no inertia, but for rounding, along a motion of its own.
bool lacks_inertia(const Mechanism& mechanism) {
  return std::any_of(mechanism.links.begin() + 1, mechanism.links.end(), [&](const Link& link) {
    const Spatial::Inertia& G = link.G;
    if (G.m <= 0) return true;
    const Eigen::Vector3d c = G.h / G.m;
    const Eigen::Matrix3d I = G.I - G.m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    const double nothing = 1e-9 * G.I.norm();  // what subtracting leaves is some 1e-16 of it
    if (mechanism.planar) return I(2, 2) <= nothing;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(I, Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[0] <= nothing;
  });
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
  bool rows_help = true;     // where the mass matrix alone is singular
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
      out.islands.emplace_back();
      dynamics.push_back(make_moving_dynamics(reduced.islands[i], i));
      try {
        assemble_island(i);
      } catch (const CannotAssemble& fault) {
        throw AssemblyError(describe_failure(scene, reduced, i, fault));
      } catch (const SingularMass& fault) {
        throw SceneError({describe_massless(scene, fault.what())});
      }
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
    const StartWishes wishes = start_wishes(wished, out.reduced, i);
    PreparedIsland& island = out.islands[i];
    island.cut_start = wishes.cuts.q;
    try {
      island.start = assemble(mechanism, *dynamics[i], wishes.tree, wishes.cuts);
      stand_at_start(i);
    } catch (const SingularMass&) {
      if (mechanism.rows == 0 || !rows_help) throw;
      Mechanism geometry = mechanism;
      give_inertia(geometry);
      island.start = assemble(geometry, *make_moving_dynamics(geometry, i), wishes.tree, wishes.cuts);
      let_rows_help(i);
    }
    if (mechanism.mass_needs_rows || mechanism.rows == 0 || !rows_help) return;
    if (!lacks_inertia(mechanism) || dynamics[i]->mass_is_definite()) return;
    let_rows_help(i);  // what stands for inertia is rounding
  }

  // Tells parts that move without inertia.
  void stand_at_start(int i) {
    std::vector<double>& q = out.islands[i].start.q;
    dynamics[i]->normalise(q.data());
    dynamics[i]->set_position(q.data());
    check_wheels(out.reduced.islands[i], *dynamics[i]);
    dynamics[i]->factorise();
  }

  void let_rows_help(int i) {
    Mechanism& mechanism = out.reduced.islands[i];
    mechanism.mass_needs_rows = true;
    dynamics[i] = make_moving_dynamics(mechanism, i);
    stand_at_start(i);
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
    const Scene near = found();
    std::exception_ptr singular;
    for (const bool help : {false, true}) {
      rows_help = help;
      for (const bool rods : {true, false}) {
        // A neighbour may have had its inertia from beyond the rod.
        rods_as_rows = rods;
        wished = rods ? near : scene;
        try {
          assemble_islands(rods ? reduced : reduce(basis()));
          rows_help = true;
          return;
        } catch (const SceneError&) {
          if (!singular) singular = std::current_exception();
        }
      }
    }
    std::rethrow_exception(singular);
  }

  // The scene with the switches of what is left to do.
  Scene basis() const { return rods_as_rows ? scene : without_rods(scene); }

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
      const std::vector<double> a = coordinates_of(wished, out.reduced, j, start.q, *dynamics[island]);
      const std::vector<double> b = coordinates_of(wished, out.reduced, j, start.equal_q, *dynamics[island]);
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
      Mechanism free_mechanism = without_drives(mechanism);
      if (mechanism.mass_needs_rows) give_inertia(free_mechanism);  // the drive may be what holds a part without any
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
  for (Mechanism& mechanism : out.islands) give_inertia(mechanism);
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
