// SPDX-License-Identifier: BSD-3-Clause
// The constraint equations of the loops, instantiated for double. Dual numbers and series are instantiated in
// residual_kernels_dual.cpp: in one file, the two prevent each other from being inlined.
#include "kinematics/loop_kernels_impl.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                    \
  template void loop_positions(const Model<A>&, Workspace<A>&);  \
  template void loop_velocities(const Model<A>&, Workspace<A>&); \
  template void loop_accelerations(const Model<A>&, Workspace<A>&, A::Scalar*);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE
template void loop_jacobian(const Model<Planar>&, const Workspace<Planar>&, SparseRows&);
template void loop_jacobian(const Model<Spatial>&, const Workspace<Spatial>&, SparseRows&);
template void cut_speed_columns(const Model<Planar>&, const Workspace<Planar>&, int, const double*, double*);
template void cut_speed_columns(const Model<Spatial>&, const Workspace<Spatial>&, int, const double*, double*);

}  // namespace gelenk::kernels
