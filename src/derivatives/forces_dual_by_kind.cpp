// SPDX-License-Identifier: BSD-3-Clause
// The kernels of forces on links, for dual numbers and series.
#include "kinematics/force_kernels_by_kind.h"
#include "kinematics/force_ports.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk::kernels {

#define GELENK_INSTANTIATE(A)                                                               \
  template void link_loads(const Model<A>&, const Loads&, const A::Scalar*, Workspace<A>&); \
  template A::Scalar force_energy(const Loads&, const Workspace<A>&);
GELENK_INSTANTIATE(PlanarAlgebra<Dual>)
GELENK_INSTANTIATE(SpatialAlgebra<Dual>)
GELENK_INSTANTIATE(PlanarAlgebra<Series>)
GELENK_INSTANTIATE(SpatialAlgebra<Series>)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
