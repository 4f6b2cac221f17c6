// SPDX-License-Identifier: BSD-3-Clause
// Rods for derivatives: dual numbers and power series in time.
#include "joint/rod_impl.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

GELENK_INSTANTIATE(PlanarAlgebra<Dual>)
GELENK_INSTANTIATE(SpatialAlgebra<Dual>)
GELENK_INSTANTIATE(PlanarAlgebra<Series>)
GELENK_INSTANTIATE(SpatialAlgebra<Series>)

}  // namespace gelenk
