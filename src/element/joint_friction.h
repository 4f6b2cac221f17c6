// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "element/coordinate_force.h"
#include "util/text.h"

namespace gelenk {

// Dry friction of a joint coordinate, a set-valued law (Coulomb; Stribeck 1902): at rest the torque takes the value,
// up to `static`, that keeps the coordinate at rest; in motion it is opposite to the speed v, with the magnitude
// coulomb + (static - coulomb) exp(-(v / stribeck)^2). A clutch or a brake is such a friction that an input engages:
// all these are multiplied by the input, below 0 by 0.
struct JointFriction {
  static constexpr std::string_view group = "friction";
  static constexpr std::string_view summary = "dry friction, which keeps the coordinate at rest up to a limit";
  static constexpr std::string_view misfit = "has more than one degree of freedom";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.stops(); }

  double coulomb = 0;                                              // N m (N), in motion
  double static_limit = std::numeric_limits<double>::quiet_NaN();  // N m (N), at rest; NaN: coulomb
  double stribeck = 0;                                             // rad/s (m/s); 0: only at rest is it larger
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

  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "dry friction on {joint}.{coordinate}, in its direction"},
      {"mode", 0, "1",
       "1, -1: {joint}.{coordinate} slips in its positive, negative direction; 0: friction or a limit keeps it at "
       "rest"}};

  std::optional<ElementFault> fault(const Coordinate& at) const {
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
  // Largest magnitude at rest [N m, N], and magnitude in a motion that begins.
  double sticking_limit(const double* u) const { return engagement(u) * full_sticking_limit(); }
  double slipping_limit(const double* u) const { return stribeck > 0 ? sticking_limit(u) : engagement(u) * coulomb; }

  // Modes: 1 and -1 in motion with positive and negative speed, 0 at rest, where the equations of motion determine the
  // torque (dynamics/locked_coordinates.h).
  template <class T>
  T held(int side, const T&, const T& v, const T* u) const {
    using std::exp;
    if (side != 1 && side != -1) return T(0);
    T magnitude(coulomb);
    if (stribeck > 0 && full_sticking_limit() > coulomb) {
      const T relative = v * T(1 / stribeck);
      magnitude += T(full_sticking_limit() - coulomb) * exp(T(-(relative * relative)));
    }
    if (is_engaged_by_input()) magnitude *= engagement(u);
    return T(-side) * magnitude;
  }
  template <class T>
  int side(const T&, const T& v) const {
    return v > T(0) ? 1 : v < T(0) ? -1 : 0;
  }
  template <class T>
  T effort(const T& q, const T& v, const T* u) const {
    return held(side(q, v), q, v, u);
  }
  // The event indicators in a mode: of motion with positive and with negative speed. a: the acceleration. x: the torque
  // that keeps the coordinate at rest, in mode 0. limit: how large it may be.
  void indicators(int side, double v, double a, double x, double limit, double* g, double* gdot) const {
    g[0] = side > 0 ? v : side < 0 ? -1 : -x - limit;
    g[1] = side < 0 ? -v : side > 0 ? -1 : x - limit;
    gdot[0] = side > 0 ? a : NAN;
    gdot[1] = side < 0 ? -a : NAN;
  }
  // For each indicator, the texts of the events at which this motion ends at rest, and at which it begins.
  static constexpr std::string_view events[2][2] = {
      {"{joint}.{coordinate} sticks", "{joint}.{coordinate} slips in its positive direction"},
      {"{joint}.{coordinate} sticks", "{joint}.{coordinate} slips in its negative direction"}};

 private:
  double full_sticking_limit() const { return std::isnan(static_limit) ? coulomb : static_limit; }
};

}  // namespace gelenk
