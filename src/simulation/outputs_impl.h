// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "math/pose_in.h"
#include "simulation/outputs.h"

namespace gelenk {
inline namespace detail {

// Q[1..4] with the scalar part not negative: one of the two that mean the same.
template <class T>
T quaternion_component(const Matrix3<T>& R, int i) {
  Eigen::Quaternion<T> Q(R);
  if (Q.w() < T(0)) Q.coeffs() = -Q.coeffs();
  return Q.coeffs()[i];
}

}  // namespace detail

template <class T>
T Outputs::value(int output, const ReadingOf<T>& reading) const {
  const Source& s = sources_[output];
  const auto component = [&s](auto&& read) {
    T joint[max_cut_nv] = {};
    read(joint);
    return T(s.sign) * joint[s.component];
  };
  switch (s.kind) {
    case Kind::tree_q:
      return T(s.sign) * reading.q[s.index];
    case Kind::tree_v:
      return T(s.sign) * reading.v[s.index];
    case Kind::tree_a:
      return T(s.sign) * reading.vdot[s.index];
    case Kind::cut_q:
      return T(s.sign) * reading.cut_q[s.index];
    case Kind::cut_v:
      if (reading.cut_v != nullptr)
        return T(s.sign) * reading.cut_v[reduced_.islands[s.island].cuts[s.index].iv + s.component];
      return component([&](T* joint) { reading.dynamics.cut_speeds(s.index, joint); });
    case Kind::cut_a:
      return component([&](T* joint) { reading.dynamics.cut_accelerations(s.index, joint); });
    case Kind::reaction:
      return reactions_[s.index].component(s.component, reading.dynamics);
    case Kind::pose:
      return pose(frames_[s.index], s.component, reading.dynamics);
    case Kind::contact_force:
      return reading.dynamics.contact_force(s.index, s.component);
    case Kind::coordinate_force:
      return reading.dynamics.coordinate_force(s.index);
    case Kind::contact_point: {
      const auto X_W0 = pose_in<SpatialAlgebra<T>>(reduced_.islands[s.island].X_W0);
      return X_W0.point(reading.dynamics.contact_point(s.index))[s.component];
    }
    case Kind::constant:
    case Kind::standing_pose:
    case Kind::energy:
      break;
  }
  return T(0);
}

template <class T>
T Outputs::pose(const BodyPlace& frame, int component, const Readings<T>& dynamics) const {
  using A = SpatialAlgebra<T>;
  const auto X_LS = pose_in<A>(frame.X_LB);
  const auto X_0L = frame.rod >= 0 ? dynamics.rod_pose(frame.rod) : dynamics.link_pose(frame.link);
  const auto X_W0 = pose_in<A>(reduced_.islands[frame.island].X_W0);
  const Matrix3<T> R_WL = X_W0.R * X_0L.R;
  if (component < 3) return X_W0.point(X_0L.point(X_LS.p))[component];
  if (component < 7) return quaternion_component<T>(R_WL * X_LS.R, component - 3);
  const auto V = frame.rod >= 0 ? dynamics.rod_velocity(frame.rod) : dynamics.link_velocity(frame.link);
  if (component < 10) return (R_WL * (V.v + V.w.cross(X_LS.p)))[component - 7];
  return X_LS.R.col(component - 10).dot(V.w);
}

}  // namespace gelenk
