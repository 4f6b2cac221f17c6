// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"

namespace gelenk {

// Weld: M coincides with F. In the tree it merges two bodies; if it closes a loop, it constrains all motions.
struct Weld : PlainJoint<0>, NoAxis {
  static constexpr std::string_view kind = "weld";
  static constexpr std::string_view summary = "rigidly connects two bodies";
  static constexpr PlanarRole planar = PlanarRole::normal;
  static constexpr std::array<Quantity, 0> q_names{};
  static constexpr std::array<Quantity, 0> v_names{};
  static constexpr std::array<Quantity, 0> a_names{};
  static constexpr bool reverses_by_half_turn = true;
  static constexpr double flip[] = {1};

  static Weld make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T*) const {
    return {};
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  void project(const T*, const typename A::Force&, T*) const {}
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion&, T*) const {}
  template <class A>
  void coordinates(const typename A::Pose&, typename A::Scalar*) const {}
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    const int n = rows::coincident<A>(X_FM, out);
    return n + rows::no_turn<A>(X_FM, out + n);
  }
};

}  // namespace gelenk
