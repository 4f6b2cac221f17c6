// SPDX-License-Identifier: BSD-3-Clause
// What depends on the kinds of forces on links: their derivatives. See also forces_dual_by_kind.cpp.
#include "derivatives/recursive_loads_impl.h"
#include "kinematics/force_ports.h"
#include "kinematics/placed_forces.h"

namespace gelenk {

template <class A>
template <class F>
auto RecursiveJacobians<A>::ports_at(const PlacedForce<F>& force) const {
  std::array<detail::PortAt<A>, PlacedForce<F>::ports> out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Body& body = body_[force.at[k].link];
    out[k] = {&force.at[k], &loads_, &body.X, &body.V, kernels::point<double>(body_[0].X, {})};
  }
  return out;
}

// The element's own derivatives, or those by dual numbers.
template <class A>
template <class F>
PortJacobians RecursiveJacobians<A>::port_jacobians(const PlacedForce<F>& force, const double* u) const {
  const auto ports = ports_at(force);
  if constexpr (HasPortJacobians<F, std::decay_t<decltype(ports[0])>>) {
    return force.element.jacobians(ports.data(), u + force.first_input());
  } else {
    const int link_a = force.at.size() == 1 ? 0 : force.at.front().link;
    const Motion U = body_[force.at.back().link].V - body_[link_a].V;
    const auto dual = detail::constant_ports(ports, loads_);
    const Eigen::Vector3d v = detail::velocity(U, ports.back().p());
    return detail::derivatives_by_duals(force.element, dual, u_.data() + force.first_input(), detail::angular(U), v);
  }
}

template <class A>
void RecursiveJacobians<A>::set_forces(const LinearizationPoint& at) {
  std::size_t n = 0;
  each_list(loads_.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      auto ports = ports_at(force);
      force.element.act(ports.data(), at.u + force.first_input());
      const auto& last = ports.back();
      add_interaction(forces_[n++], force.at.size() == 1 ? 0 : force.at.front().link, force.at.back().link,
                      detail::force_at<A>(last.p(), -last.f, -last.n));
    }
  });
}

template <class A>
template <class F>
void RecursiveJacobians<A>::force_input_derivatives(const PlacedForce<F>& force, const LinkPair& of, Jacobians& out) {
  const auto ports = ports_at(force);
  for (const int input : force.inputs()) {
    auto dual = detail::constant_ports(ports, loads_);
    for (std::size_t k = 0; k < ports.size(); ++k) {
      dual[k].rate = ports[k].v().template cast<Dual>();
      dual[k].angular_rate = ports[k].w().template cast<Dual>();
    }
    u_[input].derivatives()[0] = 1;
    force.element.act(dual.data(), u_.data() + force.first_input());
    u_[input].derivatives()[0] = 0;
    const Force by_input = detail::force_at<A>(ports.back().p(), detail::derivatives_along(dual.back().f, 0),
                                               detail::derivatives_along(dual.back().n, 0));
    add_input_derivative(by_input, of, input, out);
  }
}

template <class A>
void RecursiveJacobians<A>::forces_jacobians(const LinearizationPoint& at, Jacobians& tangent, Jacobians& out) {
  std::size_t n = 0;
  each_list(loads_.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      const LinkPair& of = forces_[n++];
      force_jacobians(port_jacobians(force, at.u), force.at.back(), of, tangent);
      if (out.of_inputs) force_input_derivatives(force, of, out);
    }
  });
}

#define GELENK_INSTANTIATE(A)                                                 \
  template void RecursiveJacobians<A>::set_forces(const LinearizationPoint&); \
  template void RecursiveJacobians<A>::forces_jacobians(const LinearizationPoint&, Jacobians&, Jacobians&);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

}  // namespace gelenk
