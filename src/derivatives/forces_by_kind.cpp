// SPDX-License-Identifier: BSD-3-Clause
// What depends on the kinds of forces on links: their derivatives, and the kernels for dual numbers and series.
#include "derivatives/recursive_loads_impl.h"
#include "kinematics/force_kernels_by_kind.h"
#include "kinematics/force_ports.h"
#include "math/series.h"

namespace gelenk {

template <class A>
template <class F>
auto RecursiveJacobians<A>::ports_at(const PlacedForce<F>& force) const {
  std::array<detail::PortAt<A>, PlacedForce<F>::ports> out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Body& body = body_[force.at[k].link];
    out[k] = {&force.at[k], &loads_, &body.X, &body.V};
  }
  return out;
}

// The element's own derivatives, or those by dual numbers.
template <class A>
template <class F>
PortJacobians RecursiveJacobians<A>::port_jacobians(const PlacedForce<F>& force, const double* u) const {
  const auto ports = ports_at(force);
  if constexpr (HasPortJacobians<F, std::decay_t<decltype(ports[0])>>) {
    return force.element.jacobians(ports.data(), u);
  } else {
    const int link_a = force.at.size() == 1 ? 0 : force.at.front().link;
    const Motion U = body_[force.at.back().link].V - body_[link_a].V;
    const auto dual = detail::constant_ports(ports, loads_);
    return detail::derivatives_by_duals(force.element, dual, u, detail::angular(U),
                                        detail::velocity(U, ports.back().p()));
  }
}

template <class A>
void RecursiveJacobians<A>::set_forces(const LinearizationPoint& at) {
  std::size_t n = 0;
  each_list(loads_.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      auto ports = ports_at(force);
      force.element.act(ports.data(), at.u + force.input);
      const auto& last = ports.back();
      add_interaction(forces_[n++], force.at.size() == 1 ? 0 : force.at.front().link, force.at.back().link,
                      detail::force_at<A>(last.p(), -last.f, -last.n));
    }
  });
}

template <class A>
template <class F>
void RecursiveJacobians<A>::force_input_derivatives(const PlacedForce<F>& force, const LinkPair& of, const double* u,
                                                    Jacobians& out) const {
  const int inputs = count_of(own_inputs(force.element));
  if (inputs == 0) return;
  const auto ports = ports_at(force);
  auto input = detail::constants(force.element, u + force.input);
  for (int i = 0; i < inputs; ++i) input[i].derivatives()[i] = 1;
  auto dual = detail::constant_ports(ports, loads_);
  force.element.act(dual.data(), input.data());
  for (int i = 0; i < inputs; ++i) {
    const Force by_input = detail::force_at<A>(ports.back().p(), detail::derivatives_along(dual.back().f, i),
                                               detail::derivatives_along(dual.back().n, i));
    add_input_derivative(by_input, of, force.input + i, out);
  }
}

template <class A>
void RecursiveJacobians<A>::forces_jacobians(const LinearizationPoint& at, Jacobians& tangent, Jacobians& out) {
  std::size_t n = 0;
  each_list(loads_.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      const LinkPair& of = forces_[n++];
      force_jacobians(port_jacobians(force, at.u + force.input), force.at.back(), of, tangent);
      if (out.of_inputs) force_input_derivatives(force, of, at.u, out);
    }
  });
}

#define GELENK_INSTANTIATE(A)                                                 \
  template void RecursiveJacobians<A>::set_forces(const LinearizationPoint&); \
  template void RecursiveJacobians<A>::forces_jacobians(const LinearizationPoint&, Jacobians&, Jacobians&);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

namespace kernels {

#define GELENK_INSTANTIATE(A)                                                               \
  template void link_loads(const Model<A>&, const Loads&, const A::Scalar*, Workspace<A>&); \
  template A::Scalar force_energy(const Loads&, const Workspace<A>&);
GELENK_INSTANTIATE(PlanarAlgebra<Dual>)
GELENK_INSTANTIATE(SpatialAlgebra<Dual>)
GELENK_INSTANTIATE(PlanarAlgebra<Series>)
GELENK_INSTANTIATE(SpatialAlgebra<Series>)
#undef GELENK_INSTANTIATE

}  // namespace kernels
}  // namespace gelenk
