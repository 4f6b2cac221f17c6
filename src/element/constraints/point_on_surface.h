// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/constraints/constraint.h"
#include "element/constraints/surface_law.h"

namespace gelenk {

// M's origin is on the surface g = 0 of F. With the unit normal n = grad g/|grad g|: w = n, Phi = g/|grad g|, of which
// n is the gradient where g = 0.
struct PointOnSurface : NoCoordinates {
  static constexpr std::string_view kind = "point_on_surface";
  static constexpr std::string_view summary = "a point of a body stays on a surface, given by an expression";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "The point"},
      {.kind = Port::Kind::frame, .name = "on", .text = "Frame of the surface", .optional = true}};
  static constexpr int row_count = 1;
  static constexpr FormulaVariable variables[] = {{"x", "m"}, {"y", "m"}, {"z", "m"}};

  Formula surface;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&PointOnSurface::surface>({.name = "surface",
                                         .text = "smooth expression of x, y, z in the frame `on` that is 0 on the "
                                                 "surface",
                                         .required = true,
                                         .settable = false,
                                         .variables = variables})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {
      {"f", 0, "N", "force on {body} along the normal, where the expression grows"}};

  std::optional<ElementFault> fault(const Coordinate&) const;
  // With the derivatives of the surface, which the following functions need.
  PointOnSurface prepared() const {
    PointOnSurface out = *this;
    out.law = SurfaceLaw(surface);
    return out;
  }

  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.contact_force(0);
  }

  // Where the gradient vanishes there is no normal.
  bool undefined(const Pose3& X_FM) const { return !law.has_normal(X_FM.p); }
  static ElementFault undefined_start() {
    return {"surface", "an expression whose gradient is 0, or no number, at the start",
            "a surface that has a normal there: check its expression and the start values"};
  }
  std::string_view near_undefined(const Pose3& X_FM) const {
    if (!undefined(X_FM)) return {};
    return "the surface on which a point of {body} stays has no normal there";
  }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using T = typename A::Scalar;
    const SurfaceLaw::Place<T> at = law.template place<T>(X_FM.p);
    out[0].w.n.setZero();
    out[0].w.f = at.normal;
    out[0].Phi = at.distance;
    return row_count;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    bias[0] += law.template normal_rate<T>(X_FM.p, V.v).dot(V.v);
  }

  SurfaceLaw law;  // see prepared()
};

}  // namespace gelenk
