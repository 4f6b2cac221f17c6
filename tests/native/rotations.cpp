// SPDX-License-Identifier: BSD-3-Clause
#include "math/spatial.h"
#include "units.h"

namespace native {

void bind_rotations(nanobind::module_& m) {
  m.def("rotation_taking_z_to", [](double x, double y, double z) {
    const Eigen::Matrix3d R = gelenk::rotation_taking_z_to({x, y, z});
    Table rows;
    for (Eigen::Index i = 0; i < 3; ++i) rows.push_back({R(i, 0), R(i, 1), R(i, 2)});
    return rows;
  });
}

}  // namespace native
