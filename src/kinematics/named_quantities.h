// SPDX-License-Identifier: BSD-3-Clause
// The coordinates and rates of joints, and outputs of sensors, that expressions name.
#pragma once

#include "kinematics/load_kernels.h"

namespace gelenk::kernels {

// Writes their values to out. reference: coordinates of the cut joints with full revolutions; readings: of the same
// state. After root_poses and loop_velocities.
template <class A>
void named_quantities(const Model<A>& model, const Loads& loads, const Workspace<A>& ws, const typename A::Scalar* q,
                      const typename A::Scalar* v, const double* reference,
                      const Readings<typename A::Scalar>& readings, typename A::Scalar* out) {
  using T = typename A::Scalar;
  int last = -1;
  CutMotion<A> of_cut;
  for (const NamedQuantity& named : loads.named) {
    if (named.reading != nullptr) {
      // Sensors read double, dual numbers and series only; for others, whoever makes the loads excludes them.
      if constexpr (requires { named.reading->read(readings); }) *out++ = named.reading->read(readings);
      continue;
    }
    if (!named.moves) {
      *out++ = T(named.value);
      continue;
    }
    if (named.cut >= 0 && named.cut != last) of_cut = counted_cut_motion(model, ws, last = named.cut, reference);
    const T* const at = named.cut < 0 ? (named.is_rate ? v : q) : named.is_rate ? of_cut.v.data() : of_cut.q.data();
    *out++ = T(named.sign) * at[named.is_rate ? named.v : named.q];
  }
}

}  // namespace gelenk::kernels
