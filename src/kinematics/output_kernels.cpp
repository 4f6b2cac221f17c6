// SPDX-License-Identifier: BSD-3-Clause
// Kernels that only outputs need, instantiated for double. Dual numbers and series are instantiated in
// residual_kernels_dual.cpp: in one file, the two prevent each other from being inlined.
#include "kinematics/output_kernels_impl.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                                                               \
  template void wrenches_of(const Model<A>&, const Workspace<A>&, const A::Scalar*, const A::Scalar*, bool, \
                            JointWrenches<A>&);                                                             \
  template void constraint_wrenches(const Model<A>&, Workspace<A>&);                                        \
  template A::Force cut_reaction(const Model<A>&, const Workspace<A>&, int);                                \
  template A::Force row_wrench(const Model<A>&, const Workspace<A>&, int, const A::Scalar*);                \
  template void cut_accelerations<A>(const Model<A>::Cut&, const Workspace<A>&, int, const A::Scalar*,      \
                                     const A::Scalar*, A::Scalar*);                                         \
  template EnergyOf<A::Scalar> energy(const Model<A>&, const Loads&, const Workspace<A>&);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE
template void accelerations(const Model<Planar>&, const double*, Workspace<Planar>&);
template void accelerations(const Model<Spatial>&, const double*, Workspace<Spatial>&);

}  // namespace gelenk::kernels
