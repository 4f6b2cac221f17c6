// SPDX-License-Identifier: BSD-3-Clause
#include "kinematics/model_impl.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

template struct Model<Planar>;
template struct Model<Spatial>;
template struct Model<PlanarAlgebra<Dual>>;
template struct Model<SpatialAlgebra<Dual>>;
template struct Model<PlanarAlgebra<Series>>;
template struct Model<SpatialAlgebra<Series>>;
template struct Workspace<Planar>;
template struct Workspace<Spatial>;
template struct Workspace<PlanarAlgebra<Dual>>;
template struct Workspace<SpatialAlgebra<Dual>>;
template struct Workspace<PlanarAlgebra<Series>>;
template struct Workspace<SpatialAlgebra<Series>>;

}  // namespace gelenk
