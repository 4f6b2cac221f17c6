// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "element/joint_forces/dry_friction.h"
#include "math/choose.h"
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
// is a friction that an input engages: all these are multiplied by the input, below 0 by 0. An expression of the size
// of the speed, of signals and of the coordinate may take the place of coulomb, static and stribeck.
struct JointFriction : DryFriction<JointFriction> {
  static constexpr std::string_view group = "friction";
  static constexpr std::string_view summary = "dry friction, which keeps the coordinate at rest up to a limit";
  static constexpr std::string_view misfit =
      "has no angles or lengths that it could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  double coulomb = std::numeric_limits<double>::quiet_NaN();       // N m (N), in motion
  double static_limit = std::numeric_limits<double>::quiet_NaN();  // N m (N), at rest; NaN: coulomb
  double stribeck = 0;                                             // rad/s (m/s); 0: only at rest is it larger
  double exponent = 2;                                             // of Stribeck's curve: 1 or 2
  Formula law;                                                     // N m (N), in motion, of the size of the speed
  double peak = 1;                                                 // static friction per that at the speed 0
  std::optional<Bearing> bearing;
  static constexpr std::string_view inputs_of_it[] = {"engagement"};
  Choice input;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointFriction::coulomb>({.name = "coulomb",
                                        .unit = "{f}",
                                        .text = "sliding friction on {coordinate}",
                                        .range = Range::not_negative,
                                        .optional = true,
                                        .tunable = true,
                                        .alternative = 1}),
        field<&JointFriction::static_limit>({.name = "static",
                                             .unit = "{f}",
                                             .text = "largest static friction on {coordinate}",
                                             .range = Range::not_negative,
                                             .optional = true,
                                             .tunable = true,
                                             .goes_with = 1}),
        field<&JointFriction::stribeck>({.name = "stribeck",
                                         .unit = "{v}",
                                         .text = "Stribeck velocity of the friction on {coordinate}",
                                         .range = Range::not_negative,
                                         .tunable = true,
                                         .goes_with = 1}),
        field<&JointFriction::exponent>({.name = "exponent",
                                         .unit = "1",
                                         .text = "exponent of |v| / stribeck in the friction on {coordinate}: 1 or 2",
                                         .settable = false,
                                         .goes_with = 1}),
        field<&JointFriction::law>({.name = "law",
                                    .unit = "{f}",
                                    .text = "sliding friction on {coordinate} as an expression of {speed}, here the "
                                            "size of the speed, of {coordinate}, t and inputs; below 0 it is 0",
                                    .range = Range::not_negative,
                                    .settable = false,
                                    .alternative = 2,
                                    .variables = variables_along,
                                    .reads = FormulaReads::signals}),
        field<&JointFriction::peak>(
            {.name = "peak",
             .unit = "1",
             .text = "largest static friction on {coordinate} per friction of `law` at the speed 0; 1 or more",
             .range = Range::positive,
             .settable = false,
             .goes_with = 2}),
        field<&JointFriction::bearing>(
            {.name = "bearing", .text = "friction on {coordinate} proportional to the force that the joint transmits"}),
        field<&JointFriction::input>({.name = "input",
                                      .text = "what an input of the model prescribes: the engagement of a clutch or "
                                              "brake, by which the friction is multiplied",
                                      .goes_with = 1,
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
    if (law.is_given()) return fault_of_law(at);
    if (peak != 1) return {{"peak", text::number(peak), "a law; with coulomb, static is the static friction"}};
    if (!(static_limit < coulomb)) return {};
    const auto shown = [&](double x) { return text::with_unit(text::number(x), spelled(unit_of("{f}", at))); };
    return {{"static", shown(static_limit), "at least coulomb, which is " + shown(coulomb)}};
  }

  // The part of the friction that acts. u: its input, if it has one.
  template <class T>
  T engagement(const T* u) const {
    if (!is_engaged_by_input()) return T(1);
    return choose(u[0], [&] { return u[0]; }, [] { return T(0); });
  }
  // Of the law: the signals that it names take the place of inputs. What decides on its branches.
  const Formula& formula() const { return law; }
  Formula& formula() { return law; }
  bool reads_speed() const { return names_variable(law, 1) || names_variable(law, 3); }
  template <class T>
  void decide(const T& q, const T& v, const T* signals, T* arguments) const {
    const T speed = v < T(0) ? T(-v) : v;
    const T at[] = {q, speed, q, speed};
    law.decide(at, signals, arguments);
  }

  double sticking_limit(double q, const double* u) const {
    return law.is_given() ? peak * law_at_rest(q, u) : engagement(u) * full_sticking_limit();
  }
  double slipping_limit(double q, const double* u) const {
    if (law.is_given()) return law_at_rest(q, u);
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
  T friction(int side, const T& q, const T& v, const T* u) const {
    if (law.is_given()) return by_law(q, T(T(side < 0 ? -1 : 1) * v), u);
    T size = stribeck_curve(side, v, coulomb, full_sticking_limit());
    if (is_engaged_by_input()) size *= engagement(u);
    return size;
  }

 private:
  // At this speed in the direction of motion; where a step continues a little beyond 0, at its size.
  template <class T>
  T by_law(const T& q, const T& speed, const T* signals) const {
    const T size = choose(T(-speed), [&] { return T(-speed); }, [&] { return speed; });
    const T at[] = {q, size, q, size};
    return law.value(at, signals);
  }
  // Branches that are held are those of the motion, which may have been fast until now.
  double law_at_rest(double q, const double* signals) const {
    const double at[] = {q, 0, q, 0};
    return law.decide<double>(at, signals, nullptr);
  }
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
    } else {
      x = choose(T(-x), [&] { return T(x / sqrt(T(T(1) + x * x))); }, [&] { return x; });
    }
    return T(in_motion) + T(at_rest - in_motion) * exp(T(-x));
  }
  std::optional<ElementFault> fault_of_law(const Coordinate& at) const {
    constexpr std::string_view in_law = "none: the law gives the friction at each speed, and peak that at rest";
    if (!std::isnan(static_limit)) return {{"static", text::number(static_limit), std::string(in_law)}};
    if (stribeck != 0) return {{"stribeck", text::number(stribeck), std::string(in_law)}};
    if (is_engaged_by_input()) return {{"input", "engagement", "an input among the names in the law"}};
    if (peak < 1) return {{"peak", text::number(peak), "1 or more"}};
    // Whoever takes the speed for a signed one writes a law that is never positive.
    if (!law.signal_names().empty() || constant_value(law) == 0.0) return {};
    for (const double speed : {0.0, 1e-3, 1.0, 1e3}) {
      const double of[] = {0, speed, 0, speed};
      if (!(law.decide<double>(of, nullptr, nullptr) <= 0)) return {};
    }
    return {{"law", text::quoted(std::string(law.text())),
             "friction above 0: " + std::string(at.speed) + " is the size of the speed, the same in both directions"}};
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
