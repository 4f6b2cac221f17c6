// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "element/constraints/constraint.h"

namespace gelenk {

// A wheel of radius r about the z axis a of M, whose tread has the radius of curvature k across, rolls without slipping
// on the x-y plane of F. With the normal n and s = |a x n|, its lowest point is c = p + (r - k) d - k n with d = ((n .
// a) a - n)/s. Each constraint equation is a force at c:
//   normal        w = n,              Phi = p_z - (r - k) s - k; w . V is its rate, since c is the lowest point
//   longitudinal  w = l = (a x n)/s   no Phi
//   lateral       w = n x l           no Phi
struct Rolling : NoCoordinates {
  static constexpr std::string_view kind = "rolling";
  static constexpr std::string_view summary = "a wheel rolls on a plane without slipping";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "Center of the wheel"},
      {.kind = Port::Kind::frame, .name = "on", .text = "The plane, with z as its normal", .optional = true}};
  static constexpr int row_count = 3;

  Direction axis = {Eigen::Vector3d::UnitY()};  // of the wheel
  double radius = 0;                            // m
  double crown = 0;                             // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Rolling::axis>({.name = "axis", .text = "axis of the wheel"}),
        field<&Rolling::radius>(
            {.name = "radius", .unit = "m", .text = "radius of the wheel", .range = Range::positive, .required = true}),
        field<&Rolling::crown>({.name = "crown",
                                .unit = "m",
                                .text = "radius of curvature of its tread across",
                                .range = Range::not_negative})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {
      {"f_n", 0, "N", "force of the ground on the wheel, along the plane's normal"},
      {"f_long", 0, "N", "force of the ground on the wheel, in the plane, along the wheel"},
      {"f_lat", 0, "N", "force of the ground on the wheel, in the plane, across the wheel"},
      {"r", 3, "m", "position of the contact point in the world", Stage::position}};

  template <class Seen>
  auto output(const Seen& seen, int group, int i) const {
    using T = decltype(seen.contact_force(0));
    if (group < row_count) return seen.contact_force(group);
    return T(seen.X_WF().point(contact_point<T>(seen.X_FM()))[i]);
  }
  static constexpr bool holds_position(int row) { return row == 0; }

  // Axis a, longitudinal direction l, direction d to the contact point, all in F, and s = |a x n|.
  template <class T>
  struct Frame {
    Vector3<T> a, l, d;
    T s;
  };
  // Undefined if the disk lies flat on the plane, s = 0, where it has no lowest point.
  template <class T>
  static Frame<T> frame(const Matrix3<T>& R) {
    Frame<T> f;
    f.a = R.col(2);
    const Vector3<T> across(f.a.y(), -f.a.x(), T(0));  // a x n
    f.s = across.norm();
    f.l = across / f.s;
    f.d = Vector3<T>(f.a.z() * f.a.x(), f.a.z() * f.a.y(), f.a.z() * f.a.z() - T(1)) / f.s;
    return f;
  }

  // Angle between the disk and the plane [rad], for small angles.
  static double tilt(const Pose3& X_FM) { return std::hypot(X_FM.R(0, 2), X_FM.R(1, 2)); }
  // The disk is too flat for a well-defined lowest point: tilt below 1e-4 rad.
  static bool undefined(const Pose3& X_FM) { return tilt(X_FM) < 1e-4; }
  static ElementFault undefined_start() {
    return {"", "the wheel flat on its plane at the start, where it has no contact point",
            "an upright or tilted wheel: check its axis and the start values of the joints that carry it"};
  }
  static constexpr double flat_tilt = 0.05;  // rad; with a smaller tilt this is the reason why a step fails
  template <class T>
  static T distance_from_undefined(const typename SpatialAlgebra<T>::Pose& X_FM) {
    return (X_FM.R(0, 2) * X_FM.R(0, 2) + X_FM.R(1, 2) * X_FM.R(1, 2)) / T(flat_tilt * flat_tilt);
  }
  static std::string_view near_undefined(const Pose3& X_FM) {
    if (tilt(X_FM) >= flat_tilt) return {};
    return "the wheel of {body} lies flat on its plane, where it has no contact point";
  }

  // Position of the contact point in F [m].
  template <class T>
  Vector3<T> contact_point(const typename SpatialAlgebra<T>::Pose& X_FM) const {
    return X_FM.p + arm<T>(frame<T>(X_FM.R));
  }

  // From the center of the wheel to the contact point.
  template <class T>
  Vector3<T> arm(const Frame<T>& f) const {
    return T(radius - crown) * f.d - Vector3<T>(T(0), T(0), T(crown));
  }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using T = typename A::Scalar;
    const Frame<T> f = frame<T>(X_FM.R);
    const Vector3<T> to_contact = arm<T>(f);
    const Vector3<T> directions[] = {{T(0), T(0), T(1)}, f.l, {-f.l.y(), f.l.x(), T(0)}};
    for (int i = 0; i < row_count; ++i) {
      out[i].w.f = directions[i];
      out[i].w.n = to_contact.cross(directions[i]);
      out[i].Phi = T(0);
    }
    out[0].Phi = X_FM.p.z() - T(radius - crown) * f.s - T(crown);
    return row_count;
  }

  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Frame<T> f = frame<T>(X_FM.R);
    // l rotates about n with the heading rate; d = a x l rotates with it and tilts with a.
    const Vector3<T> adot = V.w.cross(f.a);
    const T heading = (f.a.x() * adot.y() - f.a.y() * adot.x()) / (f.s * f.s);
    const Vector3<T> t(-f.l.y(), f.l.x(), T(0));
    const Vector3<T> ldot = heading * t;
    const Vector3<T> tdot = -heading * f.l;
    const Vector3<T> ddot = adot.cross(f.l) + f.a.cross(ldot);
    const Vector3<T> d_V = T(radius - crown) * V.w.cross(ddot);  // of the point of the wheel at c
    const Vector3<T> v_c = V.v + V.w.cross(arm<T>(f));
    bias[0] += d_V.z();
    bias[1] += f.l.dot(d_V) + ldot.dot(v_c);
    bias[2] += t.dot(d_V) + tdot.dot(v_c);
  }
};

}  // namespace gelenk
