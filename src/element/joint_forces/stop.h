// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "element/joint_forces/coordinate_force.h"
#include "math/choose.h"
#include "util/text.h"

namespace gelenk {

// Unilateral spring and damper beyond a bound of a joint coordinate: with the penetration depth it pushes back with
// max(0, stiffness depth + damping d depth/dt), and never pulls. If the damping force is limited to the size of the
// spring force, the force is also at most 2 stiffness depth, so that it does not jump at contact.
struct Stop {
  static constexpr std::string_view group = "stop";
  static constexpr std::string_view summary = "pushes back while the coordinate is beyond a bound, and never pulls";
  static constexpr std::string_view misfit =
      "has no angles or lengths that it could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  double lower = -std::numeric_limits<double>::infinity();  // rad (m); infinite if there is no bound
  double upper = std::numeric_limits<double>::infinity();   // rad (m)
  double stiffness = 0;                                     // N m/rad (N/m), more than 0
  double damping = 0;                                       // N m s/rad (N s/m)
  static constexpr std::string_view laws[] = {"linear", "limited"};
  Choice law = {0};  // index in laws

  // What a limited damping force exceeds the spring force by, and is taken off: modes 1 and -1 where it is not zero.
  std::optional<Stop> excess() const {
    if (law.index != 1 || damping == 0) return {};
    Stop out = *this;
    out.law.index = of_excess;
    return out;
  }
  bool is_excess() const { return law.index == of_excess; }

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Stop::lower>({.name = "lower",
                                                         .unit = "{q}",
                                                         .text = "lower bound of its stop, on {coordinate}",
                                                         .optional = true,
                                                         .alternative = 1}),
                                    field<&Stop::upper>({.name = "upper",
                                                         .unit = "{q}",
                                                         .text = "upper bound of its stop, on {coordinate}",
                                                         .optional = true,
                                                         .alternative = 1}),
                                    field<&Stop::stiffness>({.name = "stiffness",
                                                             .unit = "{f}/{q}",
                                                             .text = "stiffness of its stop, on {coordinate}",
                                                             .range = Range::positive,
                                                             .required = true,
                                                             .tunable = true}),
                                    field<&Stop::damping>({.name = "damping",
                                                           .unit = "{f}.s/{q}",
                                                           .text = "damping of its stop, on {coordinate}",
                                                           .range = Range::not_negative,
                                                           .tunable = true}),
                                    field<&Stop::law>({.name = "law",
                                                       .text = "damping force of its stop: proportional to the speed, "
                                                               "or also limited to the size of the spring force",
                                                       .words = laws})};
    return all;
  }

  std::optional<ElementFault> fault(const Coordinate& at) const { return fault_of_bounds(lower, upper, at); }

  // A start beyond a bound is only doubtful, not an error, since a body at rest on a stop has compressed it.
  std::optional<ElementFault> doubt(double q, const Coordinate& at) const {
    const double depth = std::max(lower - q, q - upper);
    if (!(depth > 0)) return {};
    const auto shown = [&](double x) { return text::with_unit(text::rounded(x), unit_of("{q}", at)); };
    const std::string bound =
        q > upper ? "at most stop.upper = " + shown(upper) : "at least stop.lower = " + shown(lower);
    return {{"", shown(q),
             bound + "; " + shown(depth) + " beyond it, the stop pushes with " + text::rounded(stiffness * depth, 3) +
                 " " + spelled(unit_of("{f}", at))}};
  }

  // Generalized force in a given mode, in the direction of the coordinate. side: 1 in contact at the upper bound, -1 at
  // the lower one, 0 without contact.
  template <class T>
  T held(int side, const T& q, const T& v, const T* = nullptr) const {
    if (side == 0) return T(0);
    const T depth = side > 0 ? T(q - T(upper)) : T(T(lower) - q);
    const T rate = side > 0 ? v : T(-v);
    const T spring = T(stiffness) * depth;
    const T damper = T(damping) * rate;
    return T(side) * (is_excess() ? damper - spring : -(spring + damper));
  }
  // The mode of a state: there is contact only where the stop pushes.
  template <class T>
  int side(const T& q, const T& v) const {
    const int beyond = q > T(upper) ? 1 : q < T(lower) ? -1 : 0;
    const T force = T(beyond) * held(beyond, q, v);
    return (is_excess() ? force > T(0) : force < T(0)) ? beyond : 0;
  }
  bool needs_acceleration(double q) const { return damping > 0 && (q > upper || q < lower); }  // for rates below
  // Event indicators of the upper and the lower bound, zero where contact begins or ends, and their rates; as a, NaN
  // if unknown. A damped stop pushes where stiffness depth + damping rate > 0, which ends before the depth is zero.
  void indicators(double q, double v, double a, double* g, double* gdot) const {
    const double time_constant = damping / stiffness;  // s
    for (const double side : {1.0, -1.0}) {
      const double depth = side * (q - (side > 0 ? upper : lower));
      const double rate = side * v;
      if (is_excess()) {
        const double over = damping * rate - stiffness * depth;
        *g++ = std::min(stiffness * depth, over);
        *gdot++ = stiffness * depth <= over ? stiffness * rate : damping * side * a - stiffness * rate;
        continue;
      }
      const bool releasing = time_constant > 0 && rate < 0 && depth > 0;
      *g++ = releasing ? depth + time_constant * rate : depth;
      *gdot++ = releasing ? rate + time_constant * side * a : rate;
    }
  }
  // For each indicator, the texts of the events at which it becomes negative and positive.
  static constexpr std::string_view events[2][2] = {{"{joint}.{coordinate} leaves the stop at its upper bound",
                                                     "{joint}.{coordinate} meets the stop at its upper bound"},
                                                    {"{joint}.{coordinate} leaves the stop at its lower bound",
                                                     "{joint}.{coordinate} meets the stop at its lower bound"}};
  template <class T>
  T effort(const T& q, const T& v, const T*) const {
    const std::optional<Stop> less = excess();
    return held(side(q, v), q, v) + (less ? less->held(less->side(q, v), q, v) : T(0));
  }
  template <class T>
  T energy(const T& q) const {
    if (is_excess()) return T(0);
    const T above = q - T(upper);
    const T below = T(lower) - q;
    const T depth =
        choose(above, [&] { return above; }, [&] { return choose(below, [&] { return below; }, [] { return T(0); }); });
    return T(stiffness / 2) * depth * depth;
  }

 private:
  static constexpr int of_excess = 2;  // beside the words of `law`
};

}  // namespace gelenk
