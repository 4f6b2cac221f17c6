// SPDX-License-Identifier: BSD-3-Clause
// The kernels of forces on links.
#pragma once

#include <array>
#include <type_traits>

#include "kinematics/force_ports.h"
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
    for (const auto& force : list) force.element.act(ports_of<A>(force, loads, ws).data(), u + force.first_input());
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

// A port of which the derivatives are those in BranchDirections.
template <class Port>
gelenk::detail::DualPort branching_port(const Port& port, const Loads& loads) {
  using At = BranchDirections;
  gelenk::detail::DualPort out = gelenk::detail::constant_port(port, loads);
  out.rate = port.v().template cast<Dual>();
  out.angular_rate = port.w().template cast<Dual>();
  for (int i = 0; i < 3; ++i) {
    out.at[i].derivatives()[At::along_motion] = port.v()[i];
    out.at[i].derivatives()[At::position + i] = 1;
    out.rate[i].derivatives()[At::velocity + i] = out.angular_rate[i].derivatives()[At::velocity + i] = 1;
    const Eigen::Vector3d turning = port.w().cross(Eigen::Vector3d(port.turned(Eigen::Vector3d::Unit(i))));
    for (int k = 0; k < 3; ++k) out.R(k, i).derivatives()[At::along_motion] = turning[k];
  }
  return out;
}

template <class A, class T>
void force_branches(const Loads& loads, const double* u, [[maybe_unused]] const double* rates, const Workspace<A>& ws,
                    T* arguments) {
  const auto decide = [&](const Formula& formula, const T* variables) {
    if (formula.branches() == 0) return;
    std::array<T, Formula::max_signals> signals;
    if constexpr (std::is_same_v<T, Dual>) {
      formula.take_signals(u, rates, BranchDirections::of_signals, signals.data());
    } else {
      formula.take_signals(u, signals.data());
    }
    formula.decide(variables, signals.data(), arguments + formula.first_branch());
  };
  each_list(loads.forces->lists, [&](const auto& list) {
    using F = std::decay_t<decltype(list.front().element)>;
    if constexpr (HasFormulas<F>) {
      for (const auto& force : list) {
        const auto ports = ports_of<A>(force, loads, ws);
        if constexpr (std::is_same_v<T, Dual>) {
          std::array<gelenk::detail::DualPort, PlacedForce<F>::ports> moving;
          for (std::size_t k = 0; k < ports.size(); ++k) moving[k] = branching_port(ports[k], loads);
          force.element.template with_variables<T>(moving.data(), decide);
        } else {
          force.element.template with_variables<T>(ports.data(), decide);
        }
      }
    }
  });
}

}  // namespace gelenk::kernels
