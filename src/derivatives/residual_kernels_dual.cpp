// SPDX-License-Identifier: BSD-3-Clause
// The kernels, instantiated for dual numbers and power series.
#include "kinematics/load_kernels_impl.h"
#include "kinematics/loop_kernels_impl.h"
#include "kinematics/output_kernels_impl.h"
#include "kinematics/tree_kernels_impl.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                                                                         \
  template void positions(const Model<A>&, const A::Scalar*, Workspace<A>&);                                          \
  template void root_poses(const Model<A>&, const std::vector<int>&, Workspace<A>&);                                  \
  template void velocities(const Model<A>&, const A::Scalar*, const A::Scalar*, const A::Motion&, Workspace<A>&);     \
  template void loop_positions(const Model<A>&, Workspace<A>&);                                                       \
  template void loop_velocities(const Model<A>&, Workspace<A>&);                                                      \
  template void loop_accelerations(const Model<A>&, Workspace<A>&, A::Scalar*);                                       \
  template void cut_loads(const Model<A>&, const Loads&, const A::Scalar*, const double*, Workspace<A>&, const int*); \
  template void counted_cut_coordinates<A>(const Model<A>::Cut&, const A::Pose&, const double*, A::Scalar*);          \
  template void cut_speeds<A>(const Model<A>::Cut&, const A::Pose&, const A::Motion&, const A::Scalar*, A::Scalar*);  \
  template CutMotion<A> counted_cut_motion<A>(const Model<A>&, const Workspace<A>&, int, const double*);              \
  template void accelerations(const Model<A>&, const A::Scalar*, Workspace<A>&);                                      \
  template A::Force cut_reaction(const Model<A>&, const Workspace<A>&, int);                                          \
  template A::Force row_wrench(const Model<A>&, const Workspace<A>&, int, const A::Scalar*);                          \
  template void cut_accelerations<A>(const Model<A>::Cut&, const Workspace<A>&, int, const A::Scalar*,                \
                                     const A::Scalar*, A::Scalar*);                                                   \
  template EnergyOf<A::Scalar> energy(const Model<A>&, const Loads&, const Workspace<A>&);
GELENK_INSTANTIATE(PlanarAlgebra<Dual>)
GELENK_INSTANTIATE(SpatialAlgebra<Dual>)
GELENK_INSTANTIATE(PlanarAlgebra<Series>)
GELENK_INSTANTIATE(SpatialAlgebra<Series>)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
