// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// A spring and a damper in parallel between two points at the distance L. Their tension is
// stiffness (L - length) + damping dL/dt.
struct SpringDamper {
  static constexpr std::string_view kind = "spring_damper";
  static constexpr std::string_view summary = "a spring and a damper between two points";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One end"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other end"}};

  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m
  double length = 0;     // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SpringDamper::stiffness>(
            {.name = "stiffness", .unit = "N/m", .text = "stiffness", .range = Range::not_negative, .tunable = true}),
        field<&SpringDamper::damping>(
            {.name = "damping", .unit = "N.s/m", .text = "damping", .range = Range::not_negative, .tunable = true}),
        field<&SpringDamper::length>(
            {.name = "length", .unit = "m", .text = "free length", .range = Range::not_negative, .tunable = true})};
    return all;
  }

  bool is_idle() const { return stiffness == 0 && damping == 0; }
  // Whether the force is the stiffness times the vector between the ends, which is smooth even where these coincide. In
  // all other cases the direction is undefined there.
  bool is_linear() const { return length == 0 && damping == 0; }

  template <class At, class T>
  void act(At* at, const T*) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    const auto pull = [&](const Vector3<T>& f) {
      at[0].push(f);
      at[1].push(-f);
    };
    if (is_linear()) return pull(T(stiffness) * d);
    const T L = d.norm();
    if (L == T(0)) return;  // reported by undefined()
    const Vector3<T> e = d / L;
    const T rate = e.dot(at[1].v() - at[0].v());
    pull((T(stiffness) * (L - T(length)) + T(damping) * rate) * e);
  }

  template <class T, class At>
  T energy(const At* at) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    if (is_linear()) return T(stiffness / 2) * d.squaredNorm();  // L is not differentiable where the ends coincide
    const T stretch = d.norm() - T(length);
    return T(stiffness / 2) * stretch * stretch;
  }

  template <class At>
  bool undefined(const At* at) const {
    return !is_linear() && !is_idle() && coincide(at);
  }

  // With e the direction, u the velocity of the second end relative to the body of the first and w the angular velocity
  // of its body relative to that body:
  //   de = (1 - e e^T) dp / L,   d tension = k e . dp + c (de . u + e . (du + w x dp)),   f = -tension e.
  template <class At>
  PortJacobians jacobians(const At* at, const double*) const {
    PortJacobians out{.of_points = true, .damped = damping != 0};
    const Eigen::Vector3d d = at[1].p() - at[0].p();
    if (is_linear()) {
      out.f_p.diagonal().setConstant(-stiffness);
      return out;
    }
    const double L = d.norm();
    if (L == 0) return out;
    const Eigen::Vector3d e = d / L;
    const Eigen::Vector3d u = at[1].v() - at[0].v() - at[0].w().cross(d);
    const double tension = stiffness * (L - length) + damping * e.dot(u);
    const Eigen::Vector3d tension_p =
        stiffness * e + damping * ((u - e.dot(u) * e) / L + e.cross(at[1].w() - at[0].w()));
    out.f_p = (-tension / L) * (Eigen::Matrix3d::Identity() - e * e.transpose()) - e * tension_p.transpose();
    out.f_v = -damping * e * e.transpose();
    return out;
  }
};

}  // namespace gelenk
