// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/constraints/constraint.h"

namespace gelenk {

// The velocity of M's origin has no component along the z axis a of M: w = a, no Phi.
struct KnifeEdge : NoCoordinates {
  static constexpr std::string_view kind = "knife_edge";
  static constexpr std::string_view summary = "a point of a body cannot slide along an axis of the body";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "", .text = "Contact point of the edge"},
                                   {.kind = Port::Kind::frame,
                                    .name = "on",
                                    .text = "Body on which it slides; only the body matters",
                                    .optional = true}};
  static constexpr int row_count = 1;

  Direction axis = {Eigen::Vector3d::UnitY()};

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&KnifeEdge::axis>({.name = "axis", .text = "direction in which it cannot slide"})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"f", 0, "N", "force on {body} along the axis in which it cannot slide"}};

  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.contact_force(0);
  }
  static constexpr bool holds_position(int) { return false; }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    out[0].w.n.setZero();
    out[0].w.f = X_FM.R.col(2);
    out[0].Phi = 0;
    return row_count;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Vector3<T> a = X_FM.R.col(2);
    bias[0] += V.w.cross(a).dot(V.v);
  }
};

}  // namespace gelenk
