// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "element/forces/force.h"
#include "math/dual.h"

namespace gelenk {

// Springs and dampers along and about the three axes of `from`, unloaded where the frames `from` and `to` coincide.
// With d the position and theta the rotation vector of `to` relative to `from`, both in the axes of `from`,
//   U = (d . K d + theta . K_r theta)/2,   f = -(K d + C ddot),   n = -(L(theta)^T K_r theta + C_r w) on `to`,
// where w = L(theta)^-1 dtheta/dt, L^-1 being the left Jacobian of the rotation vector (Bullo & Murray 1995,
// Proposition 4.3), so that the springs conserve energy at any angle. theta is limited to half a turn.
struct Bushing {
  static constexpr std::string_view kind = "bushing";
  static constexpr std::string_view summary = "springs and dampers along and about the axes of a frame";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "from", .text = "One end, whose axes are used"},
                                   {.kind = Port::Kind::frame, .name = "to", .text = "The other end"}};

  Eigen::Vector3d stiffness = Eigen::Vector3d::Zero();             // N/m
  Eigen::Vector3d damping = Eigen::Vector3d::Zero();               // N s/m
  Eigen::Vector3d rotational_stiffness = Eigen::Vector3d::Zero();  // N m/rad
  Eigen::Vector3d rotational_damping = Eigen::Vector3d::Zero();    // N m s/rad

  static std::span<const Field> fields() {
    static constexpr Range range = Range::not_negative;
    static constexpr Field all[] = {field<&Bushing::stiffness>({.name = "stiffness",
                                                                .unit = "N/m",
                                                                .text = "stiffness along the axes of `from`",
                                                                .range = range,
                                                                .tunable = true}),
                                    field<&Bushing::damping>({.name = "damping",
                                                              .unit = "N.s/m",
                                                              .text = "damping along the axes of `from`",
                                                              .range = range,
                                                              .tunable = true}),
                                    field<&Bushing::rotational_stiffness>({.name = "rotational_stiffness",
                                                                           .unit = "N.m/rad",
                                                                           .text = "stiffness about the axes of `from`",
                                                                           .range = range,
                                                                           .tunable = true}),
                                    field<&Bushing::rotational_damping>({.name = "rotational_damping",
                                                                         .unit = "N.m.s/rad",
                                                                         .text = "damping about the axes of `from`",
                                                                         .range = range,
                                                                         .tunable = true})};
    return all;
  }

  bool is_idle() const {
    return stiffness.isZero(0) && damping.isZero(0) && rotational_stiffness.isZero(0) && rotational_damping.isZero(0);
  }

  template <class At, class T>
  void act(At* at, const T*) const {
    const Vector3<T> p = at[1].p() - at[0].p();
    const Vector3<T> d = at[0].own(p);
    const Vector3<T> rate = at[0].own(at[1].v() - at[0].v() - at[0].w().cross(p));
    const Vector3<T> w = at[0].own(at[1].w() - at[0].w());
    const Vector3<T> theta = relative_rotation<T>(at);
    const Vector3<T> spring = rotational_stiffness.template cast<T>().cwiseProduct(theta);
    const Vector3<T> f =
        -(stiffness.template cast<T>().cwiseProduct(d) + damping.template cast<T>().cwiseProduct(rate));
    const Vector3<T> n = -(transformed<T>(theta, spring) + rotational_damping.template cast<T>().cwiseProduct(w));
    const Vector3<T> f_0 = at[0].turned(f);
    const Vector3<T> n_0 = at[0].turned(n);
    at[1].push(f_0, n_0);
    at[0].push(-f_0, -n_0 - p.cross(f_0));
  }

  template <class T, class At>
  T energy(const At* at) const {
    const Vector3<T> d = at[0].own(at[1].p() - at[0].p());
    const Vector3<T> theta = relative_rotation<T>(at);
    return (d.dot(stiffness.template cast<T>().cwiseProduct(d)) +
            theta.dot(rotational_stiffness.template cast<T>().cwiseProduct(theta))) /
           T(2);
  }

 private:
  // Rotation vector of `to` relative to `from` [rad].
  template <class T, class At>
  static Vector3<T> relative_rotation(const At* at) {
    Matrix3<T> R;
    for (int i = 0; i < 3; ++i) R.col(i) = at[0].own(at[1].turned(Vector3<T>(Vector3<T>::Unit(i))));
    return rotation_vector(R);
  }

  // L(theta)^T x, L^T = 1 + [theta]x/2 + c [theta]x^2 with a = |theta| and c = (1 - (a/2) cot(a/2))/a^2.
  template <class T>
  static Vector3<T> transformed(const Vector3<T>& theta, const Vector3<T>& x) {
    using std::cos;
    using std::sin;
    using std::sqrt;
    constexpr double series_limit = 1e-2;  // rad^2; relative error of the series there: a^8/4.8e7 / (1/12) = 2.5e-15
    const T a2 = theta.squaredNorm();
    T c = T(1. / 12) + a2 * (T(1. / 720) + a2 * (T(1. / 30240) + a2 * T(1. / 1209600)));
    if (value_of(a2) > series_limit) {
      const T a = sqrt(a2);
      c = (T(1) - a / T(2) * cos(a / T(2)) / sin(a / T(2))) / a2;
    }
    const Vector3<T> across = theta.cross(x);
    return x + across / T(2) + c * theta.cross(across);
  }
};

}  // namespace gelenk
