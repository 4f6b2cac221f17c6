// SPDX-License-Identifier: BSD-3-Clause
// The kernels of forces on links.
#pragma once

#include <array>

#include "kinematics/load_kernels.h"
#include "kinematics/placed_forces.h"
#include "kinematics/ports.h"

namespace gelenk::kernels {

template <class A, class F, class W>
auto ports_of(const PlacedForce<F>& force, const Loads& loads, W& ws) {
  std::array<PortOn<A, W>, PlacedForce<F>::ports> out;
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = {force.at[k], loads, ws};
  return out;
}

template <class A>
void link_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, Workspace<A>& ws) {
  for (std::size_t i = 0; i < model.links.size(); ++i) ws.F_ext[i] = {};
  each_list(loads.forces->lists, [&](const auto& list) {
    for (const auto& force : list) force.element.act(ports_of<A>(force, loads, ws).data(), u + force.input);
  });
}

template <class A>
typename A::Scalar force_energy(const Loads& loads, const Workspace<A>& ws) {
  typename A::Scalar sum(0);
  each_list(loads.forces->lists, [&](const auto& list) {
    for (const auto& force : list) {
      const auto ports = ports_of<A>(force, loads, ws);
      if constexpr (requires { force.element.template energy<typename A::Scalar>(ports.data()); }) {
        sum += force.element.template energy<typename A::Scalar>(ports.data());
      }
    }
  });
  return sum;
}

}  // namespace gelenk::kernels
