// SPDX-License-Identifier: BSD-3-Clause
// The interface of force elements, which act on one body or between two. A force has one or two ports and
//
//   act(at, u)         applies forces by at[i].push(f, n) or at[i].push_along(f, n); those on two ports are opposite
//   energy(at)         stored energy [J]; optional
//   jacobians(at, u)   PortJacobians of the force on its last port; optional, otherwise dual numbers are used
//   undefined(at)      whether its direction is undefined at these positions of its ports; optional
//   is_local()         whether it depends on neither the positions nor the velocities of its ports; optional
//   output(at, group)   value of an output, a number, at these ports, as act(); with outputs
//   is_idle()          whether it has no effect with its present values; optional
//   each_formula(element, visit)  its expressions (field/formula.h), if it has any; and
//   with_variables(at, use)  calls use(formula, variables) for each of them
//
// u: its inputs; all of the scene, if it has expressions. at[i] has the motion of port i, with vectors in the axes of a
// fixed frame common to all ports:
//   p(), v()           position [m] and velocity [m/s] of its origin
//   w()                angular velocity [rad/s]
//   turned(x)          transforms a vector from the axes of the port to those of the common frame
//   own(x)             transforms a vector from the axes of the common frame to those of the port
//   from_world(x)      transforms a vector from the axes of the world to those of the common frame; to_world(x): back
//   world_position()   position [m] of its origin in the world
//   push(f, n)         applies a force [N] at the origin of the port and optionally a torque [N m] to the body
//   push_along(f, n)   the same with f and n in the axes of the port
// Numbers are of type double, Dual or Series.
#pragma once

#include <concepts>

#include "element/element.h"

namespace gelenk {

// A port that keeps what is applied to it: the sums of the forces f [N] and the torques n [N m], in the axes of the
// common frame.
template <class T>
struct RecordingPort {
  using Vector = Vector3<T>;
  Vector at{Vector::Zero()}, rate{Vector::Zero()}, angular_rate{Vector::Zero()};
  Matrix3<T> R{Matrix3<T>::Zero()};                // the port's axes, in those of the common frame
  Matrix3<T> R_0W{Matrix3<T>::Zero()};             // the world's
  Eigen::Vector3d p_W0 = Eigen::Vector3d::Zero();  // m, position of the common frame in the world
  Vector f{Vector::Zero()}, n{Vector::Zero()};

  const Vector& p() const { return at; }
  const Vector& v() const { return rate; }
  const Vector& w() const { return angular_rate; }
  Vector turned(const Vector& x) const { return R * x; }
  Vector own(const Vector& x) const { return R.transpose() * x; }
  Vector from_world(const Vector& x) const { return R_0W * x; }
  Vector to_world(const Vector& x) const { return R_0W.transpose() * x; }
  Vector world_position() const { return to_world(at) + p_W0.template cast<T>(); }

  void push(const Vector& force) { f += force; }
  void push(const Vector& force, const Vector& torque) {
    f += force;
    n += torque;
  }
  void push_along(const Vector& force, const Vector& torque) { push(R * force, R * torque); }
};

// Partial derivatives of the force f and the torque n that an element applies at its last port: with respect to the
// displacement p and the rotation a [rad] of this port relative to the first one (or to the world if it is the only
// one), and to the velocities v and w.
struct PortJacobians {
  Eigen::Matrix3d f_p = Eigen::Matrix3d::Zero(), f_a = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d n_p = Eigen::Matrix3d::Zero(), n_a = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d f_v = Eigen::Matrix3d::Zero(), f_w = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d n_v = Eigen::Matrix3d::Zero(), n_w = Eigen::Matrix3d::Zero();
  bool of_points = false;  // whether derivatives of n and with respect to a and w are zero
  bool damped = true;      // whether derivatives with respect to v and w may be nonzero
};

template <class F>
concept HasFormulas = requires(F& f) { F::each_formula(f, [](const Formula&) {}); };

// Elements with derivatives of their own, given their ports; for others dual numbers are used.
template <class F, class At>
concept HasPortJacobians = requires(const F& f, const At* at, const double* u) { f.jacobians(at, u); };

inline constexpr std::size_t max_force_ports = 2;

// Whether two ports are so near to each other that the direction between them is not defined.
template <class At>
bool coincide(const At* at) {
  constexpr double min_distance = 1e-9;  // m; below it, rounding errors of 1e-15 m leave fewer than six digits
  return (at[1].p() - at[0].p()).norm() <= min_distance;
}

template <class F>
concept ForceElement = requires {
  { F::kind } -> std::convertible_to<std::string_view>;
  { F::summary } -> std::convertible_to<std::string_view>;
  { F::fields() } -> std::convertible_to<std::span<const Field>>;
} && (std::size(F::ports) >= 1 && std::size(F::ports) <= max_force_ports);

}  // namespace gelenk
