// SPDX-License-Identifier: BSD-3-Clause
// Loads: forces between bodies and along joint coordinates.
#pragma once

#include <array>

#include "kinematics/kernels.h"
#include "kinematics/loads.h"
#include "math/dual.h"

namespace gelenk::kernels {

// Gravity as an acceleration of the root in the opposite direction. Read at each evaluation, since gravity is tunable.
template <class A>
typename A::Motion root_acceleration(const Loads& loads) {
  using T = typename A::Scalar;
  const Eigen::Vector3d& g = loads.gravity;
  typename A::Motion out{};
  if constexpr (A::planar) {
    out = {T(0), T(-g.x()), T(-g.y())};
  } else {
    out.v = (-g).cast<T>();
  }
  return out;
}

// Overwrites ws.F_ext with the forces between bodies. u: all inputs of the scene. After velocities.
template <class A>
void link_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, Workspace<A>& ws);
// Potential energy [J] of the forces between bodies.
template <class A>
typename A::Scalar force_energy(const Loads& loads, const Workspace<A>& ws);

// Directions of derivatives of what decides on the branches of expressions: along the motion with constant velocities,
// of positions, of velocities, and of inputs other than the time.
struct BranchDirections {
  static constexpr int along_motion = 0, position = 1, velocity = 4, inputs = 7;
  static constexpr Formula::SignalDirections of_signals = {along_motion, position, inputs};
};
// What decides on the branches of the expressions of forces between bodies. arguments: by branch of all expressions of
// the island; T: double, or Dual with these derivatives. u: signals, at least those that are named, and their rates
// (Formula::take_signals). After velocities.
template <class A, class T>
void force_branches(const Loads& loads, const double* u, const double* rates, const Workspace<A>& ws, T* arguments);

// Adds motors, springs and stops of cut joints as pairs of wrenches to ws.F_ext, and stores them in ws.F_cut.
// reference: coordinates of the cut joints with full revolutions. sides: see JointLoads::add, cut by cut. After
// loop_velocities.
template <class A>
void cut_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, const double* reference,
               Workspace<A>& ws, const int* sides = nullptr);

// Coordinates of a cut joint, with angles within half a revolution of `reference`.
template <class A>
void counted_cut_coordinates(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const double* reference,
                             typename A::Scalar* q);
// Velocities of a cut joint at its pose X_FM and coordinates q, from that of M relative to F, at M's origin in F.
template <class A>
void cut_speeds(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const typename A::Motion& V_FM,
                const typename A::Scalar* q, typename A::Scalar* v);
template <class A>
struct CutMotion {
  std::array<typename A::Scalar, max_cut_nq> q;
  std::array<typename A::Scalar, 6> v;
};
// Coordinates and velocities of cut joint c. reference: of all cuts.
template <class A>
CutMotion<A> counted_cut_motion(const Model<A>& model, const Workspace<A>& ws, int c, const double* reference);

// Calls visit(force, q, v) for all forces with modes, in the order of SwitchingForces, with the coordinates and
// velocities to which they refer. After loop_velocities.
template <class A, class Visit>
void each_switching(const Model<A>& model, const Loads& loads, const Workspace<A>& ws, const typename A::Scalar* q,
                    const typename A::Scalar* v, const double* reference, Visit visit) {
  loads.tree.each_switching([&](const auto& force) { visit(force, q, v); });
  for (int c = 0; c < static_cast<int>(loads.cuts.size()); ++c) {
    if (!loads.cuts[c].has_branches()) continue;
    const CutMotion<A> at = counted_cut_motion(model, ws, c, reference);
    loads.cuts[c].each_switching([&](const auto& force) { visit(force, at.q.data(), at.v.data()); });
  }
}

}  // namespace gelenk::kernels
