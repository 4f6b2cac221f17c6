// SPDX-License-Identifier: BSD-3-Clause
// A tree joint with F, not M, on the outer body. Its coordinates and velocities are those of the joint J itself.
//   X_MF = X_FM^-1      V_MF = -Ad(X_FM) S v      bias: -Ad(X_FM) Sdot v, as V x V = 0
#pragma once

#include "joint/base.h"

namespace gelenk {

template <class J>
struct Reversed : J {
  static constexpr bool constant_S = false;
  static constexpr int shifts_in_F = 0;

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    return J::template X_FM<A>(q).inverse();
  }
  template <class A, class T>
  typename A::Motion V_FM(const T* q, const T* v) const {
    return T(-1) * J::template X_FM<A>(q).to_parent(J::template V_FM<A>(q, v));
  }
  template <class A, class T>
  typename A::Motion bias(const T* q, const T* v) const {
    return T(-1) * J::template X_FM<A>(q).to_parent(J::template bias<A>(q, v));
  }
  template <class A, class T>
  void project(const T* q, const typename A::Force& F, T* tau) const {
    J::template project<A>(q, T(-1) * J::template X_FM<A>(q).to_child(F), tau);
  }
  template <class A, class T>
  void speeds(const T* q, const typename A::Motion& V, T* v) const {
    J::template speeds<A>(q, T(-1) * J::template X_FM<A>(q).to_child(V), v);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_MF, typename A::Scalar* q) const {
    J::template coordinates<A>(X_MF.inverse(), q);
  }
};

}  // namespace gelenk
