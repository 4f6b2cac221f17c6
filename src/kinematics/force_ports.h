// SPDX-License-Identifier: BSD-3-Clause
// Ports of forces (element/forces/force.h) for derivatives: they store the applied force and torque, as doubles or with
// derivatives as dual numbers.
#pragma once

#include <array>
#include <tuple>

#include "element/forces/force.h"
#include "kinematics/coordinate_derivatives.h"
#include "kinematics/ports.h"

namespace gelenk::detail {

inline Eigen::Vector3d angular(const Spatial::Motion& V) { return V.w; }
inline Eigen::Vector3d angular(const Planar::Motion& V) { return {0, 0, V.w}; }
// The velocity of the point p, in the axes of V and from the same origin.
inline Eigen::Vector3d velocity(const Spatial::Motion& V, const Eigen::Vector3d& p) { return V.v + V.w.cross(p); }
inline Eigen::Vector3d velocity(const Planar::Motion& V, const Eigen::Vector3d& p) {
  return {V.x - V.w * p.y(), V.y + V.w * p.x(), 0};
}

// A force's port at the current pose of its link (element/forces/force.h), in the root's axes. It sums up the force f
// [N] and the torque n [N m] that are applied to it.
template <class A>
struct PortAt {
  const Attachment* at = nullptr;
  const Loads* loads = nullptr;
  const typename A::Pose* X = nullptr;
  const typename A::Motion* V = nullptr;             // about the common reference point
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the root, from the same point
  Eigen::Vector3d f = Eigen::Vector3d::Zero(), n = Eigen::Vector3d::Zero();

  Eigen::Vector3d p() const { return kernels::point<double>(*X, *at); }
  Eigen::Vector3d v() const { return velocity(*V, p()); }
  Eigen::Vector3d w() const { return angular(*V); }
  Eigen::Vector3d turned(const Eigen::Vector3d& x) const { return kernels::to_root<double>(*X, at->R * x); }
  Eigen::Vector3d own(const Eigen::Vector3d& x) const { return at->R.transpose() * kernels::to_link<double>(*X, x); }
  Eigen::Vector3d from_world(const Eigen::Vector3d& x) const { return loads->R_0W * x; }
  Eigen::Vector3d to_world(const Eigen::Vector3d& x) const { return loads->R_0W.transpose() * x; }
  Eigen::Vector3d world_position() const { return to_world(p() - origin) + loads->p_W0; }

  void push(const Eigen::Vector3d& force) { f += force; }
  void push(const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
    f += force;
    n += torque;
  }
  void push_along(const Eigen::Vector3d& force, const Eigen::Vector3d& torque) { push(turned(force), turned(torque)); }
};

// A port with derivatives.
using DualPort = RecordingPort<Dual>;

// The port at rest, with zero derivatives.
template <class Port>
DualPort constant_port(const Port& port, const Loads& loads) {
  DualPort out;
  out.at = port.p().template cast<Dual>();
  for (int i = 0; i < 3; ++i) out.R.col(i) = port.turned(Eigen::Vector3d::Unit(i)).template cast<Dual>();
  out.R_0W = loads.R_0W.cast<Dual>();
  out.p_W0 = port.world_position() - port.to_world(port.p());
  return out;
}

// Seeds the derivatives of a port: directions 0 to 2 are its displacement, 3 to 5 its rotation; wrt_rates: the rates of
// these. w, v: its angular velocity and velocity. The velocity changes with the displacement, since the motion of the
// body is constant.
inline void seed(DualPort& port, const Eigen::Vector3d& w, const Eigen::Vector3d& v, bool wrt_rates) {
  port.rate = v.cast<Dual>();
  port.angular_rate = w.cast<Dual>();
  for (int d = 0; d < 3; ++d) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(d);
    if (wrt_rates) {
      port.rate[d].derivatives()[d] = port.angular_rate[d].derivatives()[3 + d] = 1;
      continue;
    }
    port.at[d].derivatives()[d] = 1;
    const Eigen::Vector3d carried_along = w.cross(unit);
    for (int i = 0; i < 3; ++i) port.rate[i].derivatives()[d] = carried_along[i];
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d axis(port.R(0, c).value(), port.R(1, c).value(), port.R(2, c).value());
      const Eigen::Vector3d d_axis = unit.cross(axis);
      for (int i = 0; i < 3; ++i) port.R(i, c).derivatives()[3 + d] = d_axis[i];
    }
  }
}

// An element's inputs, with zero derivatives.
template <class E>
std::array<Dual, dual_directions> constants(const E& element, const double* u) {
  std::array<Dual, dual_directions> out;
  for (int i = 0; i < count_of(own_inputs(element)); ++i) out[i] = Dual(u[i]);
  return out;
}

template <class Ports>
auto constant_ports(const Ports& ports, const Loads& loads) {
  std::array<DualPort, std::tuple_size_v<Ports>> out;
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = constant_port(ports[k], loads);
  return out;
}

inline Eigen::Vector3d derivatives_along(const Vector3<Dual>& x, int direction) {
  return {x[0].derivatives()[direction], x[1].derivatives()[direction], x[2].derivatives()[direction]};
}

// Derivatives of a force with respect to the motion of its last port, the others being at rest: a force depends on the
// relative motion of its ports only. input: its inputs. w, v: angular velocity and velocity of the last port relative
// to the others.
template <class E, class Ports>
PortJacobians derivatives_by_duals(const E& element, const Ports& ports, const Dual* input, const Eigen::Vector3d& w,
                                   const Eigen::Vector3d& v) {
  PortJacobians out;
  for (const bool wrt_rates : {false, true}) {
    Ports moved = ports;
    seed(moved.back(), w, v, wrt_rates);
    element.act(moved.data(), input);
    for (int d = 0; d < 3; ++d) {
      (wrt_rates ? out.f_v : out.f_p).col(d) = derivatives_along(moved.back().f, d);
      (wrt_rates ? out.f_w : out.f_a).col(d) = derivatives_along(moved.back().f, 3 + d);
      (wrt_rates ? out.n_v : out.n_p).col(d) = derivatives_along(moved.back().n, d);
      (wrt_rates ? out.n_w : out.n_a).col(d) = derivatives_along(moved.back().n, 3 + d);
    }
  }
  return out;
}

}  // namespace gelenk::detail
