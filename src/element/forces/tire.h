// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "element/forces/force.h"
#include "math/dual.h"
#include "util/text.h"

namespace gelenk {

// Forces of a road, z = road(x) in the frame `on`, on a wheel of radius r about the axis a, with slip. In the axes of
// `on`, with the normal n = z, s = |a x n|, the heading l = (a x n)/s, t = n x l, the direction d = ((n . a) a - n)/s
// to the lowest point of the wheel, the height h of its center above the road and the road's gradient road' there:
//   deflection   delta = r s - h, of the lowest point of the free wheel
//   normal force N = load + max(stiffness delta + damping ddelta/dt, 0) where delta > 0, else load; along n - road' x
//   slips        kappa = -(l . v)/V, tan alpha = (t . v)/V; v: velocity of the wheel at h/s below its center along d,
//                V: the speed of its center along l, from which V is smoothly kept away from 0 (speed())
//   linear       f_long = slip_stiffness kappa N, f_lat = -cornering_stiffness tan alpha N
//   with limits  the Magic Formula (Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, eq. 4.6) in the similarity method
//                (sec. 4.2): with e = (slip_stiffness kappa/mu_long, -cornering_stiffness tan alpha/mu_lat),
//                f_i = mu_i N (e_i/|e|) G_i(|e|), G_i(e) = sin(C_i atan(x - E_i (x - atan x))), x = e/C_i
// so that B = stiffness/(C mu), D = mu N, and each pure slip has its own curve.
//   with curves  f_long, f_lat as expressions of kappa, alpha and N
struct Tire {
  static constexpr std::string_view kind = "tire";
  static constexpr std::string_view summary =
      "a tire that slips on a road: linear, with the Magic Formula or by expressions";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "Center of the wheel", .on_ground = false},
      {.kind = Port::Kind::frame, .name = "on", .text = "The road, with z as its normal", .optional = true}};

  static constexpr FormulaVariable variables[] = {{"tire_slip", "1"}, {"tire_angle", "rad"}, {"tire_load", "N"}};

  Direction axis = {Eigen::Vector3d::UnitY()};  // of the wheel
  double radius = 0;                            // m
  double stiffness = 0;                         // N/m
  double damping = 0;                           // N s/m
  double load = 0;                              // N
  double slip_stiffness = 0;
  double cornering_stiffness = 0;  // 1/rad
  // Of the Magic Formula, long and lat; mu not finite: linear.
  double friction_long = std::numeric_limits<double>::quiet_NaN();
  double friction_lat = std::numeric_limits<double>::quiet_NaN();
  double shape_long = 1.65, shape_lat = 1.3;     // C
  double curvature_long = 0, curvature_lat = 0;  // E
  Formula force_long, force_lat;                 // N, in place of the above
  double standstill = 0.1;                       // m/s
  double bump_position = 0;                      // m
  double bump_length = 1;                        // m
  double bump_height = 0;                        // m

  static std::span<const Field> fields() {
    static constexpr auto number = [](FieldInfo info) {
      info.tunable = true;
      return info;
    };
    static constexpr Field all[] = {
        field<&Tire::axis>({.name = "axis", .text = "axis of the wheel"}),
        field<&Tire::radius>({.name = "radius",
                              .unit = "m",
                              .text = "radius of the free wheel",
                              .range = Range::positive,
                              .required = true}),
        field<&Tire::stiffness>(number(
            {.name = "stiffness", .unit = "N/m", .text = "normal force per deflection", .range = Range::not_negative})),
        field<&Tire::damping>(number({.name = "damping",
                                      .unit = "N.s/m",
                                      .text = "normal force per rate of the deflection",
                                      .range = Range::not_negative})),
        field<&Tire::load>(number({.name = "load",
                                   .unit = "N",
                                   .text = "normal force in addition, at any height",
                                   .range = Range::not_negative})),
        field<&Tire::slip_stiffness>(number({.name = "slip_stiffness",
                                             .unit = "1",
                                             .text = "longitudinal force per small slip and normal force",
                                             .range = Range::not_negative})),
        field<&Tire::cornering_stiffness>(number({.name = "cornering_stiffness",
                                                  .unit = "1/rad",
                                                  .text = "lateral force per small slip angle and normal force",
                                                  .range = Range::not_negative})),
        field<&Tire::friction_long>(number({.name = "friction_long",
                                            .unit = "1",
                                            .text = "largest longitudinal force per normal force, D/N; linear without",
                                            .range = Range::positive,
                                            .optional = true})),
        field<&Tire::friction_lat>(number({.name = "friction_lat",
                                           .unit = "1",
                                           .text = "largest lateral force per normal force, D/N; linear without",
                                           .range = Range::positive,
                                           .optional = true})),
        field<&Tire::shape_long>(number(
            {.name = "shape_long", .unit = "1", .text = "shape factor C, longitudinal", .range = Range::positive})),
        field<&Tire::shape_lat>(
            number({.name = "shape_lat", .unit = "1", .text = "shape factor C, lateral", .range = Range::positive})),
        field<&Tire::curvature_long>(
            number({.name = "curvature_long", .unit = "1", .text = "curvature factor E, longitudinal"})),
        field<&Tire::curvature_lat>(
            number({.name = "curvature_lat", .unit = "1", .text = "curvature factor E, lateral"})),
        field<&Tire::force_long>(
            {.name = "force_long",
             .unit = "N",
             .text = "expression of tire_slip, tire_angle and tire_load for the longitudinal force, in place of these",
             .settable = false,
             .variables = variables}),
        field<&Tire::force_lat>({.name = "force_lat",
                                 .unit = "N",
                                 .text = "the same for the lateral force, with force_long",
                                 .settable = false,
                                 .variables = variables}),
        field<&Tire::standstill>(number({.name = "standstill",
                                         .unit = "m/s",
                                         .text = "speed below which slip is relative to a mean of it and the speed",
                                         .range = Range::positive})),
        field<&Tire::bump_position>(
            number({.name = "bump_position", .unit = "m", .text = "x of the top of a bump across the road"})),
        field<&Tire::bump_length>(number({.name = "bump_length",
                                          .unit = "m",
                                          .text = "distance in which it falls to exp(-1/2) of its height",
                                          .range = Range::positive})),
        field<&Tire::bump_height>(number({.name = "bump_height", .unit = "m", .text = "its height"}))};
    return all;
  }
  static constexpr SignalGroup outputs[] = {
      {"f_n", 0, "N", "force of the road on the wheel, along its normal", Stage::velocity},
      {"f_long", 0, "N", "force of the road on the wheel, along its heading", Stage::velocity},
      {"f_lat", 0, "N", "force of the road on the wheel, across its heading", Stage::velocity},
      {"slip", 0, "1", "longitudinal slip, positive when driving", Stage::velocity},
      {"slip_angle", 0, "rad", "slip angle, with the sign of the lateral velocity", Stage::velocity},
      {"tau", 0, "N.m", "torque of the road about the axis of the wheel", Stage::velocity}};

  std::optional<ElementFault> fault(const Coordinate&) const {
    if (force_long.is_given() != force_lat.is_given()) {
      const bool lacks_lat = force_long.is_given();
      return ElementFault{.field = lacks_lat ? "force_lat" : "force_long",
                          .found = "nothing",
                          .expected = lacks_lat ? "an expression, since force_long is given"
                                                : "an expression, since force_lat is given"};
    }
    if (has_curves() && has_numbers())
      return ElementFault{.field = "force_long",
                          .found = "expressions and a stiffness, friction, shape or curvature of the tire",
                          .expected = "one of them"};
    if (std::isfinite(friction_long) != std::isfinite(friction_lat)) {
      const bool lacks_lat = std::isfinite(friction_long);
      return ElementFault{
          .field = lacks_lat ? "friction_lat" : "friction_long",
          .found = "nothing",
          .expected = lacks_lat ? "a number, since friction_long is given" : "a number, since friction_lat is given"};
    }
    for (const bool lat : {false, true}) {
      const double E = lat ? curvature_lat : curvature_long;
      if (E > 1)  // beyond, the force changes its sign at large slips
        return ElementFault{
            .field = lat ? "curvature_lat" : "curvature_long", .found = text::number(E), .expected = "at most 1"};
    }
    return {};
  }

  bool is_idle() const { return stiffness == 0 && damping == 0 && load == 0; }

  // Of curves of slip.
  template <class Self, class Visit>
  static void each_formula(Self& self, Visit visit) {
    visit(self.force_long);
    visit(self.force_lat);
  }
  template <class T, class At, class Use>
  void with_variables(const At* at, Use use) const {
    if (!has_curves()) return;
    const std::array<T, 3> variables = contact<T>(at).variables();
    use(force_long, variables.data());
    use(force_lat, variables.data());
  }

  // In the axes of `on`.
  template <class T>
  struct Contact {
    Vector3<T> f, n;       // force [N] and torque [N m] on the wheel, about its center
    T f_n, f_long, f_lat;  // N
    T slip, tan_alpha;     // kappa, tan alpha
    T tau;                 // N m

    T slip_angle() const {
      using std::atan2;
      return atan2(tan_alpha, T(1));
    }
    std::array<T, 3> variables() const { return {slip, slip_angle(), f_n}; }
  };

  // Whether the wheel lies flat on the road, where it has no heading, and no force.
  template <class At>
    requires requires(const At* at) { at->turned(Eigen::Vector3d()); }
  bool undefined(const At* at) const {
    return !is_idle() && at[1].own(axis_of<double>(at[0])).template head<2>().norm() < least_sine;
  }

  template <class At, class T>
  void act(At* at, const T*) const {
    const Vector3<T> p = at[0].p() - at[1].p();
    const Contact<T> on = contact<T>(at);
    const Vector3<T> f = at[1].turned(on.f);
    const Vector3<T> n = at[1].turned(on.n);
    at[0].push(f, n);
    at[1].push(-f, -n - p.cross(f));
  }

  template <class T, class At>
  T energy(const At* at) const {
    const T delta = deflection<T>(at[1].own(at[0].p() - at[1].p()), at[1].own(axis_of<T>(at[0])));
    return value_of(delta) > 0 ? T(T(stiffness / 2) * delta * delta) : T(0);
  }

  template <class T, class At>
  T output(const At* at, int group) const {
    const Contact<T> on = contact<T>(at);
    const T all[] = {on.f_n, on.f_long, on.f_lat, on.slip, on.slip_angle(), on.tau};
    return all[group];
  }

 private:
  bool has_curves() const { return force_long.is_given(); }
  bool has_numbers() const {
    const Tire plain;
    return slip_stiffness != 0 || cornering_stiffness != 0 || std::isfinite(friction_long) ||
           shape_long != plain.shape_long || shape_lat != plain.shape_lat || curvature_long != 0 || curvature_lat != 0;
  }

  // A wheel that lies flatter than this on the road has no heading.
  static constexpr double least_sine = 1e-6;

  template <class T, class Port>
  Vector3<T> axis_of(const Port& wheel) const {
    return wheel.turned(Vector3<T>(axis.along.template cast<T>()));
  }

  template <class T>
  T road(const T& x) const {
    using std::exp;
    if (bump_height == 0) return T(0);
    const T u = (x - T(bump_position)) / T(bump_length);
    return T(bump_height) * exp(-u * u / T(2));
  }
  template <class T>
  T road_gradient(const T& x) const {
    return -road(x) * (x - T(bump_position)) / T(bump_length * bump_length);
  }

  template <class T>
  T deflection(const Vector3<T>& p, const Vector3<T>& a) const {
    using std::sqrt;
    return T(radius) * sqrt(a.x() * a.x() + a.y() * a.y()) - (p.z() - road(p.x()));
  }

  // The speed to which slips refer: |v| from standstill on, and below it the parabola that continues it smoothly.
  template <class T>
  T speed(const T& v) const {
    using std::abs;
    if (std::abs(value_of(v)) >= standstill) return abs(v);
    return (T(standstill) + v * v / T(standstill)) / T(2);
  }

  template <class T>
  static T magic(const T& e, double C, double E) {
    using std::atan2;
    using std::sin;
    const T x = e / T(C);
    return sin(T(C) * atan2(x - T(E) * (x - atan2(x, T(1))), T(1)));
  }

  // Forces in units of the normal force: from the slips, each times its stiffness.
  template <class T>
  void limit(T& f_long, T& f_lat) const {
    using std::sqrt;
    if (!std::isfinite(friction_long)) return;
    const T e_long = f_long / T(friction_long);
    const T e_lat = f_lat / T(friction_lat);
    const T square = e_long * e_long + e_lat * e_lat;
    if (value_of(square) < 1e-16) return;  // linear to rounding
    const T e = sqrt(square);
    f_long *= magic(e, shape_long, curvature_long) / e;
    f_lat *= magic(e, shape_lat, curvature_lat) / e;
  }

  template <class T, class At>
  Contact<T> contact(const At* at) const {
    const Vector3<T> p_0 = at[0].p() - at[1].p();
    return contact<T>(at[1].own(p_0), at[1].own(at[0].v() - at[1].v() - at[1].w().cross(p_0)),
                      at[1].own(at[0].w() - at[1].w()), at[1].own(axis_of<T>(at[0])));
  }

  // p, v: of the center of the wheel; w: its angular velocity; a: its axis.
  template <class T>
  [[gnu::noinline]] Contact<T> contact(const Vector3<T>& p, const Vector3<T>& v, const Vector3<T>& w,
                                       const Vector3<T>& a) const {
    using std::sqrt;
    Contact<T> out{Vector3<T>::Zero(), Vector3<T>::Zero(), T(load), T(0), T(0), T(0), T(0), T(0)};
    const T s = sqrt(a.x() * a.x() + a.y() * a.y());
    if (value_of(s) < least_sine) {
      out.f_n = T(0);
      return out;
    }
    const Vector3<T> l(a.y() / s, -a.x() / s, T(0));
    const Vector3<T> t(-l.y(), l.x(), T(0));
    const Vector3<T> d(a.z() * a.x() / s, a.z() * a.y() / s, (a.z() * a.z() - T(1)) / s);
    const T gradient = road_gradient(p.x());
    const T delta = deflection(p, a);
    const Vector3<T> to_lowest = T(radius) * d;
    if (value_of(delta) > 0) {
      const T rate = gradient * v.x() - v.z() - w.cross(to_lowest).z();
      const T spring = T(stiffness) * delta + T(damping) * rate;
      if (value_of(spring) > 0) out.f_n += spring;
    }
    const Vector3<T> to_road = (p.z() - road(p.x())) / s * d;
    const Vector3<T> v_c = v + w.cross(to_road);
    const T V = speed(T(l.dot(v)));
    out.slip = -l.dot(v_c) / V;
    out.tan_alpha = t.dot(v_c) / V;
    if (has_curves()) {
      const std::array<T, 3> at = out.variables();
      const bool touches = value_of(out.f_n) > 0;
      if (touches) out.f_long = force_long.value(at.data());
      if (touches) out.f_lat = force_lat.value(at.data());
    } else {
      T f_long = T(slip_stiffness) * out.slip;
      T f_lat = -T(cornering_stiffness) * out.tan_alpha;
      limit(f_long, f_lat);
      out.f_long = f_long * out.f_n;
      out.f_lat = f_lat * out.f_n;
    }
    const Vector3<T> along = out.f_long * l + out.f_lat * t;
    const Vector3<T> normal(T(0), T(0), out.f_n);
    out.f = along + normal - Vector3<T>(out.f_n * gradient, T(0), T(0));
    out.n = to_road.cross(along) + to_lowest.cross(normal);
    out.tau = a.dot(out.n);
    return out;
  }
};

}  // namespace gelenk
