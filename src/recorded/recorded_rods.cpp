// SPDX-License-Identifier: BSD-3-Clause
// Rods for numbers that record.
#include "joint/rod_impl.h"
#include "recorded/recorded_algebra.h"

namespace gelenk {

GELENK_INSTANTIATE(PlanarAlgebra<Recorded>)
GELENK_INSTANTIATE(SpatialAlgebra<Recorded>)

}  // namespace gelenk
