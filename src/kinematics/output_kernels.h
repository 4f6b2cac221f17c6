// SPDX-License-Identifier: BSD-3-Clause
// Quantities that are computed only when they are read: accelerations, reactions, energies; and conversions from the
// algebra of a mechanism to spatial algebra.
#pragma once

#include "kinematics/kernels.h"
#include "kinematics/readings.h"

namespace gelenk::kernels {

// Sets ws.A_full of every link, and ws.F: the wrench of each tree joint on its outer link L, in L. Reads ws.lambda and
// the loads.
template <class A>
void accelerations(const Model<A>& model, const typename A::Scalar* vdot, Workspace<A>& ws);

// The wrench of each tree joint on its outer link L, in L, for these accelerations and multipliers; alone: of these
// only, at rest and without loads. Leaves the workspace as it is. Allocates in the first call.
template <class A>
struct JointWrenches {
  std::vector<typename A::Motion> accelerations;
  std::vector<typename A::Force> F;
};
template <class A>
void wrenches_of(const Model<A>& model, const Workspace<A>& ws, const typename A::Scalar* vdot,
                 const typename A::Scalar* lambda, bool alone, JointWrenches<A>& out);

// Sets ws.F and cut_reaction() to the wrenches of ws.lambda alone, at rest and without loads.
template <class A>
void constraint_wrenches(const Model<A>& model, Workspace<A>& ws);

// Accelerations of a cut joint, at its coordinates q and velocities v. After accelerations.
template <class A>
void cut_accelerations(const typename Model<A>::Cut& cut, const Workspace<A>& ws, int c, const typename A::Scalar* q,
                       const typename A::Scalar* v, typename A::Scalar* a);

// The wrench of a cut joint on M, in M: constraint forces, motors and springs.
template <class A>
typename A::Force cut_reaction(const Model<A>& model, const Workspace<A>& ws, int c);

// The part of it that is due to the constraint equations, with these multipliers.
template <class A>
typename A::Force row_wrench(const Model<A>& model, const Workspace<A>& ws, int c, const typename A::Scalar* lambda);

// Kinetic and potential energy [J] of links, gravity and forces; gravity's is zero at the world's origin.
template <class A>
EnergyOf<typename A::Scalar> energy(const Model<A>& model, const Loads& loads, const Workspace<A>& ws);

// The spatial pose, motion or force of one in algebra A. height [m]: along the normal of a planar mechanism.
template <class A>
typename SpatialAlgebra<typename A::Scalar>::Pose pose3(const typename A::Pose& X, double height) {
  if constexpr (A::planar) {
    using T = typename A::Scalar;
    typename SpatialAlgebra<T>::Pose out;
    out.R << X.c, -X.s, T(0), X.s, X.c, T(0), T(0), T(0), T(1);
    out.p << X.px, X.py, T(height);
    return out;
  } else {
    return X;
  }
}
template <class A>
typename SpatialAlgebra<typename A::Scalar>::Motion motion3(const typename A::Motion& V) {
  if constexpr (A::planar) {
    using T = typename A::Scalar;
    return {Vector3<T>(T(0), T(0), V.w), Vector3<T>(V.x, V.y, T(0))};
  } else {
    return V;
  }
}
template <class A>
typename SpatialAlgebra<typename A::Scalar>::Force force3(const typename A::Force& F) {
  if constexpr (A::planar) {
    using T = typename A::Scalar;
    return {Vector3<T>(T(0), T(0), F.n), Vector3<T>(F.x, F.y, T(0))};
  } else {
    return F;
  }
}

}  // namespace gelenk::kernels
