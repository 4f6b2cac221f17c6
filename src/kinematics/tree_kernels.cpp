// SPDX-License-Identifier: BSD-3-Clause
// The recursions along the tree, instantiated for double. Dual numbers and series are instantiated in
// residual_kernels_dual.cpp: in one file, the two prevent each other from being inlined.
#include "kinematics/tree_kernels_impl.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                                        \
  template void positions(const Model<A>&, const A::Scalar*, Workspace<A>&);         \
  template void root_poses(const Model<A>&, const std::vector<int>&, Workspace<A>&); \
  template void velocities(const Model<A>&, const A::Scalar*, const A::Scalar*, const A::Motion&, Workspace<A>&);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE
template void inverse_dynamics_bias(const Model<Planar>&, Workspace<Planar>&, double*);
template void inverse_dynamics_bias(const Model<Spatial>&, Workspace<Spatial>&, double*);
template void mass_matrix(const Model<Planar>&, Workspace<Planar>&, SparseFactor&);
template void mass_matrix(const Model<Spatial>&, Workspace<Spatial>&, SparseFactor&);

}  // namespace gelenk::kernels
