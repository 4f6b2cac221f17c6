// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "element/constraint.h"

namespace gelenk {

// A thin disc of this radius about z of M rolls on the plane without slip. With the axis a and the normal n,
// s = |a x n|, the disc's lowest point is c = p + r d with d = ((n . a) a - n)/s. Rows, each a force at c:
//   normal        w = n,              Phi = p_z - r s, whose rate it is: along the disc d is stationary
//   longitudinal  w = l = (a x n)/s   no Phi
//   lateral       w = n x l           no Phi
struct Rolling : NoCoordinates {
  static constexpr std::string_view kind = "rolling";
  static constexpr std::string_view summary = "a wheel, a thin disc, rolls on a plane without slip";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "Centre of the wheel"},
      {.kind = Port::Kind::frame, .name = "on", .text = "The plane, z its normal", .optional = true}};
  static constexpr int row_count = 3;

  Direction axis = {Eigen::Vector3d::UnitY()};  // of the wheel
  double radius = 0;                            // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Rolling::axis>({.name = "axis", .text = "axis of the wheel"}),
                                    field<&Rolling::radius>({.name = "radius",
                                                             .unit = "m",
                                                             .text = "radius of the wheel",
                                                             .range = Range::positive,
                                                             .required = true})};
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

  template <class T>
  struct Frame {
    Vector3<T> a, l, d;
    T s;
  };
  // Where the disc lies flat on the plane, s = 0, there is no lowest point.
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

  // rad: how far the disc is from lying flat on the plane.
  static double tilt(const Pose3& X_FM) { return std::hypot(X_FM.R(0, 2), X_FM.R(1, 2)); }
  // It lies too flat to tell where its lowest point is.
  static bool undefined(const Pose3& X_FM) { return tilt(X_FM) < 1e-4; }
  static ElementFault undefined_start() {
    return {"", "the wheel flat on its plane at the start, where it has no point of contact",
            "it upright or tilted: check its axis and the start values of the joints that carry it"};
  }
  static std::string_view near_undefined(const Pose3& X_FM) {
    constexpr double nearly_flat = 0.05;  // rad: a wheel that lies this near to its plane is why a step fails
    if (tilt(X_FM) >= nearly_flat) return {};
    return "the wheel of {body} has come to lie flat on its plane, where it has no point of contact";
  }

  // In F.
  template <class T>
  Vector3<T> contact_point(const typename SpatialAlgebra<T>::Pose& X_FM) const {
    return X_FM.p + T(radius) * frame<T>(X_FM.R).d;
  }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using T = typename A::Scalar;
    const Frame<T> f = frame<T>(X_FM.R);
    const Vector3<T> arm = T(radius) * f.d;
    const Vector3<T> directions[] = {{T(0), T(0), T(1)}, f.l, {-f.l.y(), f.l.x(), T(0)}};
    for (int i = 0; i < row_count; ++i) {
      out[i].w.f = directions[i];
      out[i].w.n = arm.cross(directions[i]);
      out[i].Phi = T(0);
    }
    out[0].Phi = X_FM.p.z() - T(radius) * f.s;
    return row_count;
  }

  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Frame<T> f = frame<T>(X_FM.R);
    // l turns about n with the heading; d = a x l turns with it and tilts with a.
    const Vector3<T> adot = V.w.cross(f.a);
    const T heading = (f.a.x() * adot.y() - f.a.y() * adot.x()) / (f.s * f.s);
    const Vector3<T> t(-f.l.y(), f.l.x(), T(0));
    const Vector3<T> ldot = heading * t;
    const Vector3<T> tdot = -heading * f.l;
    const Vector3<T> ddot = adot.cross(f.l) + f.a.cross(ldot);
    const Vector3<T> d_V = T(radius) * V.w.cross(ddot);  // of the point of the disc that is lowest
    const Vector3<T> v_c = V.v + T(radius) * V.w.cross(f.d);
    bias[0] += d_V.z();
    bias[1] += f.l.dot(d_V) + ldot.dot(v_c);
    bias[2] += t.dot(d_V) + tdot.dot(v_c);
  }
};

}  // namespace gelenk
