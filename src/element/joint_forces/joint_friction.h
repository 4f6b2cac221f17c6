// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "element/joint_forces/dry_friction.h"
#include "util/text.h"

namespace gelenk {

// The part of dry friction that is proportional to the force R that the joint transmits across its axis [N].
struct Bearing {
  double coefficient = 0;                                                // 1, in motion
  double static_coefficient = std::numeric_limits<double>::quiet_NaN();  // 1, at rest; NaN: coefficient
  double radius = std::numeric_limits<double>::quiet_NaN();              // m, of a bearing; NaN: a guide has none

  // Which of the forces it is that agree with the motion, where constraint equations are redundant.
  static constexpr std::string_view reactions[] = {"least_norm"};
  Choice reaction;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Bearing::coefficient>({.name = "coefficient",
                                      .unit = "1",
                                      .text = "coefficient of sliding friction of the bearing or guide of {coordinate}",
                                      .range = Range::not_negative,
                                      .required = true,
                                      .tunable = true}),
        field<&Bearing::static_coefficient>(
            {.name = "static",
             .unit = "1",
             .text = "coefficient of static friction of the bearing or guide of {coordinate}",
             .range = Range::not_negative,
             .optional = true,
             .tunable = true}),
        field<&Bearing::radius>({.name = "radius",
                                 .unit = "m",
                                 .text = "radius of the bearing of {coordinate}; of rotations only",
                                 .range = Range::positive,
                                 .optional = true,
                                 .tunable = true}),
        field<&Bearing::reaction>({.name = "reaction",
                                   .text = "the force that counts where redundant constraint equations leave it "
                                           "undetermined; otherwise such mechanisms are refused",
                                   .words = reactions})};
    return all;
  }

  double full_static() const { return std::isnan(static_coefficient) ? coefficient : static_coefficient; }
};

// Dry friction of a joint coordinate, a set-valued law (Coulomb; Stribeck 1902): at rest the torque takes the value,
// up to `static`, that keeps the coordinate at rest; in motion it is opposite to the speed v, with the magnitude
// coulomb + (static - coulomb) exp(-(|v| / stribeck)^exponent). A bearing adds coefficient radius R, with the force R
// that the joint transmits across its axis, which depends on friction; a guide adds coefficient R. A clutch or a brake
// is a friction that an input engages: all these are multiplied by the input, below 0 by 0.
struct JointFriction : DryFriction<JointFriction> {
  static constexpr std::string_view group = "friction";
  static constexpr std::string_view summary = "dry friction, which keeps the coordinate at rest up to a limit";
  static constexpr std::string_view misfit = "has more than one degree of freedom";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.stops(); }

  double coulomb = 0;                                              // N m (N), in motion
  double static_limit = std::numeric_limits<double>::quiet_NaN();  // N m (N), at rest; NaN: coulomb
  double stribeck = 0;                                             // rad/s (m/s); 0: only at rest is it larger
  double exponent = 2;                                             // of Stribeck's curve: 1 or 2
  std::optional<Bearing> bearing;
  static constexpr std::string_view inputs_of_it[] = {"engagement"};
  Choice input;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointFriction::coulomb>({.name = "coulomb",
                                        .unit = "{f}",
                                        .text = "sliding friction on {coordinate}",
                                        .range = Range::not_negative,
                                        .required = true,
                                        .tunable = true}),
        field<&JointFriction::static_limit>({.name = "static",
                                             .unit = "{f}",
                                             .text = "largest static friction on {coordinate}",
                                             .range = Range::not_negative,
                                             .optional = true,
                                             .tunable = true}),
        field<&JointFriction::stribeck>({.name = "stribeck",
                                         .unit = "{v}",
                                         .text = "Stribeck velocity of the friction on {coordinate}",
                                         .range = Range::not_negative,
                                         .tunable = true}),
        field<&JointFriction::exponent>({.name = "exponent",
                                         .unit = "1",
                                         .text = "exponent of |v| / stribeck in the friction on {coordinate}: 1 or 2",
                                         .settable = false}),
        field<&JointFriction::bearing>(
            {.name = "bearing", .text = "friction on {coordinate} proportional to the force that the joint transmits"}),
        field<&JointFriction::input>({.name = "input",
                                      .text = "what an input of the model prescribes: the engagement of a clutch or "
                                              "brake, by which the friction is multiplied",
                                      .words = inputs_of_it})};
    return all;
  }

  bool is_engaged_by_input() const { return input.index != Choice::none; }
  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup engagement[] = {
        {"engagement", 0, "1",
         "part of the dry friction on {joint}.{coordinate} that acts: 0 released, 1 fully engaged; below 0: 0"}};
    if (!is_engaged_by_input()) return {};
    return engagement;
  }

  std::optional<ElementFault> fault(const Coordinate& at) const {
    if (bearing) {
      if (std::optional<ElementFault> found = fault_of_bearing(at)) return found;
    }
    if (exponent != 1 && exponent != 2) return {{"exponent", text::number(exponent), "1 or 2"}};
    if (!(static_limit < coulomb)) return {};
    const auto shown = [&](double x) { return text::with_unit(text::number(x), spelled(unit_of("{f}", at))); };
    return {{"static", shown(static_limit), "at least coulomb, which is " + shown(coulomb)}};
  }

  // The part of the friction that acts. u: its input, if it has one.
  template <class T>
  T engagement(const T* u) const {
    if (!is_engaged_by_input()) return T(1);
    return u[0] > T(0) ? u[0] : T(0);
  }
  double sticking_limit(double, const double* u) const { return engagement(u) * full_sticking_limit(); }
  double slipping_limit(double q, const double* u) const {
    return stribeck > 0 ? sticking_limit(q, u) : engagement(u) * coulomb;
  }
  bool is_guide() const { return bearing && std::isnan(bearing->radius); }
  // Friction per force that the bearing or guide transmits, in motion in the mode `side` at the speed v [m, 1]; and at
  // rest, and in a motion that begins.
  template <class T>
  T load_factor(int side, const T& v, const T* u) const {
    if (!bearing) return T(0);
    return engagement(u) * T(arm()) * stribeck_curve(side, v, bearing->coefficient, bearing->full_static());
  }
  double sticking_load_factor(const double* u) const {
    return bearing ? engagement(u) * arm() * bearing->full_static() : 0;
  }
  double slipping_load_factor(const double* u) const {
    return !bearing ? 0 : stribeck > 0 ? sticking_load_factor(u) : engagement(u) * arm() * bearing->coefficient;
  }

  template <class T>
  T friction(int side, const T&, const T& v, const T* u) const {
    T size = stribeck_curve(side, v, coulomb, full_sticking_limit());
    if (is_engaged_by_input()) size *= engagement(u);
    return size;
  }

 private:
  double full_sticking_limit() const { return std::isnan(static_limit) ? coulomb : static_limit; }
  // Of the friction force in a bearing [m]; of a guide 1.
  double arm() const { return std::isnan(bearing->radius) ? 1 : bearing->radius; }
  // From `at_rest` to `in_motion`. Smooth where a step of the mode `side` continues beyond its end; there exp(-x) would
  // soon overflow, and x is bounded by 1.
  template <class T>
  T stribeck_curve(int side, const T& v, double in_motion, double at_rest) const {
    using std::exp;
    using std::sqrt;
    if (!(stribeck > 0 && at_rest > in_motion)) return T(in_motion);
    T x = v * T((side < 0 ? -1 : 1) / stribeck);
    if (exponent != 1) {
      x = T(x * x);
    } else if (x < T(0)) {
      x = x / sqrt(T(T(1) + x * x));
    }
    return T(in_motion) + T(at_rest - in_motion) * exp(T(-x));
  }
  std::optional<ElementFault> fault_of_bearing(const Coordinate& at) const {
    const auto shown = [](double x) { return text::number(x); };
    if (bearing->static_coefficient < bearing->coefficient)
      return {{"bearing.static", shown(bearing->static_coefficient),
               "at least coefficient, which is " + shown(bearing->coefficient)}};
    if (at.is_angle && std::isnan(bearing->radius))
      return {{"bearing", "no radius", "the radius at which the friction of a rotation acts"}};
    if (!at.is_angle && !std::isnan(bearing->radius))
      return {{"bearing.radius", text::with_unit(shown(bearing->radius), "m"),
               "no radius: the friction of a guide is the coefficient times the force across it"}};
    return {};
  }
};

}  // namespace gelenk
