// SPDX-License-Identifier: BSD-3-Clause
// The loads, instantiated for double. Dual numbers and series are instantiated in residual_kernels_dual.cpp: in one
// file, the two prevent each other from being inlined.
#include "kinematics/load_kernels_impl.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                                                                         \
  template void cut_loads(const Model<A>&, const Loads&, const A::Scalar*, const double*, Workspace<A>&, const int*); \
  template void counted_cut_coordinates<A>(const Model<A>::Cut&, const A::Pose&, const double*, A::Scalar*);          \
  template void cut_speeds<A>(const Model<A>::Cut&, const A::Pose&, const A::Motion&, const A::Scalar*, A::Scalar*);  \
  template CutMotion<A> counted_cut_motion<A>(const Model<A>&, const Workspace<A>&, int, const double*);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
