// SPDX-License-Identifier: BSD-3-Clause
// Friction that is proportional to a force that the mechanism transmits: of bearings and guides to that of their joint,
// of gears to the torque of the mesh. These forces depend on friction themselves (dynamics/loaded_friction.h).
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kinematics/kernels.h"
#include "kinematics/loads.h"
#include "kinematics/output_kernels.h"
#include "kinematics/visit.h"

namespace gelenk {

// One of these forces, and the friction to which it belongs.
struct FrictionLoad {
  enum class Of { bearing, guide, mesh };
  Of of = Of::bearing;
  int force = 0;                     // index of the friction among all forces with modes
  int velocity = 0;                  // of its coordinate: in the tree, or among those of the cut
  double sign = 1;                   // user's coordinate = sign times the mechanism's
  int cut = -1;                      // of a bearing that closes a loop
  int link = -1;                     // of a joint of the tree
  int row = -1;                      // of a mesh: which of the coordinate rows
  double factor = 1;                 // of the coordinate in that row
  bool may_be_undetermined = false;  // the force of least norm counts where constraint equations are redundant

  // Friction per size of the load against motion in a direction (1, -1; in the user's sign). along: of a mesh, a number
  // with the sign of its force. of_mesh: MeshLosses::at(). of_bearing: the same of a bearing or guide.
  template <class T>
  T friction_per_size(int direction, double along, const std::array<T, 2>& of_mesh, const T& of_bearing) const {
    return of == Of::mesh ? of_mesh[direction * sign * along < 0 ? 0 : 1] : of_bearing;
  }
};

template <class A>
// NOLINTNEXTLINE(readability-function-cognitive-complexity): one kind of force after the other
std::vector<FrictionLoad> friction_loads(const Model<A>& model, const Loads& loads) {
  std::vector<FrictionLoad> out;
  int index = 0;
  const auto add = [&](const auto& force, int cut) {
    if constexpr (TakesLoads<std::decay_t<decltype(force.element)>>) {
      FrictionLoad load{.force = index, .velocity = force.v, .sign = force.sign, .cut = cut};
      for (std::size_t i = 1; i < model.links.size() && cut < 0; ++i) {
        if (model.links[i].iv == force.v && model.links[i].nv == 1) load.link = static_cast<int>(i);
      }
      if (force.element.bearing) {
        load.may_be_undetermined = force.element.bearing->reaction.index != Choice::none;
        load.of = force.element.is_guide() ? FrictionLoad::Of::guide : FrictionLoad::Of::bearing;
        out.push_back(load);
      }
      for (std::size_t r = 0; r < model.coordinate_rows.size() && cut < 0; ++r) {
        const CoordinateRow& row = model.coordinate_rows[r];
        if (!row.has_losses()) continue;
        const CoordinateRow::Term& term = row.terms[static_cast<std::size_t>(row.lossy_term)];
        if (term.v != force.v) continue;
        load.of = FrictionLoad::Of::mesh;
        load.may_be_undetermined = false;
        load.row = static_cast<int>(r);
        load.factor = term.factor;
        out.push_back(load);
      }
    }
    ++index;
  };
  loads.tree.each_switching([&](const auto& force) { add(force, -1); });
  for (std::size_t c = 0; c < loads.cuts.size(); ++c)
    loads.cuts[c].each_switching([&](const auto& force) { add(force, static_cast<int>(c)); });
  return out;
}

// In the plane, the angle of a cut revolute joint is a sum of angles of tree joints: its rate by velocity. Changes the
// positions in ws; the angular parts of S are the same at all of them.
template <class A>
std::vector<std::pair<int, typename A::Scalar>> turn_of_cut_joint(const Model<A>& model, int cut, Workspace<A>& ws) {
  using T = typename A::Scalar;
  std::vector<std::pair<int, T>> out;
  if constexpr (A::planar) {
    const std::vector<T> q(static_cast<std::size_t>(model.nq));
    kernels::positions(model, q.data(), ws);
    const auto add_path = [&](const std::vector<int>& links, double sign) {
      for (const int i : links) {
        const auto& link = model.links[i];
        for (int k = link.iv; k < link.iv + link.nv; ++k) {
          if (ws.S[k].w != T(0)) out.emplace_back(k, T(sign) * ws.S[k].w);
        }
      }
    };
    add_path(model.cuts[cut].path_b, 1);
    add_path(model.cuts[cut].path_a, -1);
  }
  return out;
}

// The force of a load: of a mesh along the coordinate; of bearings and guides across their axis. F: the wrench of each
// tree joint on its outer link; lambda: the multipliers.
template <class A>
std::array<typename A::Scalar, 3> transmitted_force(const FrictionLoad& load, const Model<A>& model,
                                                    const Workspace<A>& ws, const std::vector<typename A::Force>& F,
                                                    const typename A::Scalar* lambda) {
  using T = typename A::Scalar;
  if (load.of == FrictionLoad::Of::mesh)
    return {T(-load.factor) * lambda[model.first_coordinate_row + load.row], T(0), T(0)};
  if constexpr (A::planar) {
    const typename A::Force at =
        load.cut < 0 ? F[static_cast<std::size_t>(load.link)] : kernels::row_wrench(model, ws, load.cut, lambda);
    if (load.of == FrictionLoad::Of::bearing) return {at.x, at.y, T(0)};
    const typename A::Motion& axis = ws.S[static_cast<std::size_t>(load.velocity)];
    return {axis.x * at.y - axis.y * at.x, T(0), T(0)};
  } else {
    const typename A::Motion& S = ws.S[static_cast<std::size_t>(load.velocity)];
    const Vector3<T>& axis = load.of == FrictionLoad::Of::bearing ? S.w : S.v;
    const Vector3<T>& f = F[static_cast<std::size_t>(load.link)].f;
    const Vector3<T> across = f - axis.dot(f) * axis;
    return {across[0], across[1], across[2]};
  }
}

// Its size; where it vanishes, with the derivative 0.
template <class T>
T size_of_load(const std::array<T, 3>& force) {
  using std::sqrt;
  const T squared = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
  return squared == T(0) ? T(0) : sqrt(squared);
}

}  // namespace gelenk
