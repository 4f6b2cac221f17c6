// SPDX-License-Identifier: BSD-3-Clause
// The kernels of forces on links, for numbers that record.
#include "kinematics/force_kernels_by_kind.h"
#include "recorded/recorded_forces.h"

namespace gelenk::kernels {

template <class A>
std::vector<int> hidden_branches(const Loads& loads, const Recorded* u, Workspace<A>& ws) {
  std::vector<int> out;
  each_list(loads.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      try {
        force.element.act(ports_of<A>(force, loads, ws).data(), u + force.first_input());
      } catch (const recording::HiddenBranch&) {
        out.push_back(force.force);
      }
    }
  });
  return out;
}

#define GELENK_INSTANTIATE(A)                                                               \
  template void link_loads(const Model<A>&, const Loads&, const A::Scalar*, Workspace<A>&); \
  template A::Scalar force_energy(const Loads&, const Workspace<A>&);                       \
  template std::vector<int> hidden_branches(const Loads&, const Recorded*, Workspace<A>&);
GELENK_INSTANTIATE(PlanarAlgebra<Recorded>)
GELENK_INSTANTIATE(SpatialAlgebra<Recorded>)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
