// SPDX-License-Identifier: BSD-3-Clause
// What is computed only when somebody reads it: accelerations, reactions, energies; and the way back from the
// algebra of a mechanism to space.
#pragma once

#include "dynamics/dynamics.h"
#include "dynamics/kernels.h"

namespace gelenk::kernels {

// ws.A_full of every link, and ws.F: the wrench of each tree joint on its outer link, in it.
template <class A>
void accelerations(const Model<A>& model, const typename A::Scalar* vdot, Workspace<A>& ws);

// ws.F and cut_reaction() of ws.lambda alone, nothing moving and no loads.
template <class A>
void constraint_wrenches(const Model<A>& model, Workspace<A>& ws);

template <class A>
void cut_accelerations(const typename Model<A>::Cut& cut, const Workspace<A>& ws, int c, const double* q,
                       const double* v, double* a);

// On M in M: the rows' forces, drives and springs.
template <class A>
typename A::Force cut_reaction(const Model<A>& model, const Workspace<A>& ws, int c);

// Gravity's part counts from the world's origin.
template <class A>
Energy energy(const Model<A>& model, const Loads& loads, const Workspace<A>& ws);

inline Pose3 pose3(const Spatial::Pose& X, double) { return X; }
inline Pose3 pose3(const Planar::Pose& X, double height) {
  Pose3 out;
  out.R << X.c, -X.s, 0, X.s, X.c, 0, 0, 0, 1;
  out.p << X.px, X.py, height;
  return out;
}
inline Spatial::Motion motion3(const Spatial::Motion& V) { return V; }
inline Spatial::Motion motion3(const Planar::Motion& V) { return {{0, 0, V.w}, {V.x, V.y, 0}}; }
inline Spatial::Force force3(const Spatial::Force& F) { return F; }
inline Spatial::Force force3(const Planar::Force& F) { return {{0, 0, F.n}, {F.x, F.y, 0}}; }

}  // namespace gelenk::kernels
