// SPDX-License-Identifier: BSD-3-Clause
// The interface of elements that act along a coordinate of a joint, with the user's signs:
//
//   effort(q, v, u)       generalized force tau [N m, N] on the coordinate q [rad, m] with the speed v; u: its inputs
//   jacobians(q, v)       partial derivatives of tau with respect to q and v; optional, otherwise dual numbers are used
//   energy(q)             stored energy [J]; optional
//   inertia()             inertia [kg m2, kg] added to the coordinate; optional
//   is_idle()             whether it has no effect with its present values; optional
//   doubt(q, coordinate)  warning about a start at q; optional
//
// An element with modes (a stop) also has
//   side(q, v)            the mode of a state: 1, -1, or 0 for no contact
//   held(side, q, v, u)   tau in a given mode, used in place of effort()
//   indicators(q, v, g, gdot)   two event indicators, which are zero where the modes 1 and -1 begin and end, and their
//                         rates
//   events[2][2]          for each indicator the texts of the events at which it becomes negative and positive
//   excess(), is_excess() a second element beside it, with modes that are no events for the user; optional
//
// Elements that can keep their coordinate at rest, with a force that is not theirs to compute, have indicators for a
// given mode; x: the generalized force that keeps the coordinate at rest. One whose mode 0 is rest is a law of friction
// (dry_friction.h), which has
//   sticking_limit(q, u)  largest |tau| that keeps the coordinate at rest
//   slipping_limit(q, u)  |tau| in a motion that begins
//   indicators(side, v, a, x, limit, g, gdot)    a: acceleration, or NaN; limit: of all friction, and rounding
//   load_factor(side, v, u), ...   if it depends on loads, see joint_friction.h
// and one whose modes 1 and -1 are contact (limit) has
//   depth(side, q), touch_tolerance(side), restitution, is_poisson()
//   indicators(side, q, v, x, adhesion, g, gdot)
// or, if they bound the speed instead of the position (`bounds_speed`; a one-way clutch),
//   indicators(side, v, a, x, adhesion, g, gdot)
//
// and one that holds all coordinates of its joint at rest while it is engaged (`holds_joint`; a lock), which the first
// coordinate has for all, has the modes 1 and 0 and
//   engagement(u)         above 0 while it is engaged
//
// An element with modes may have two output signals: its force and its mode.
//
// Elements among the fields of a joint (spring, damper, stop, friction, limit) also have `group`, the name of their
// mapping in the joint, or empty if they have none, and fits(kind), whether joints of a type can have them.
#pragma once

#include <optional>

#include "element/element.h"
#include "util/text.h"

namespace gelenk {

// Elements with derivatives of their own; for others dual numbers are used.
template <class F>
concept HasJacobians = requires(const F& f, double x) { f.jacobians(x, x); };

template <class F>
concept Switches = requires(const F& f, double x) { f.side(x, x); };

// Elements that can keep their coordinate at rest, by friction and in contact.
template <class F>
concept Sticks = Switches<F> && requires(const F& f, const double* u) { f.sticking_limit(0.0, u); };
template <class F>
concept Blocks = Switches<F> && requires(const F& f) { f.restitution; };
// Friction that may depend on the forces which bearings, guides and meshes transmit.
template <class F>
concept TakesLoads = Sticks<F> && requires(const F& f, const double* u) { f.sticking_load_factor(u); };
// Of those in contact, the ones that bound the speed.
template <class F>
concept BoundsSpeed = Blocks<F> && requires { F::bounds_speed; };

// Elements that an input makes keep all coordinates of their joint at rest.
template <class F>
concept HoldsJoint = Switches<F> && requires { F::holds_joint; };

// The variables of expressions along a coordinate: of an angle or of a length.
inline constexpr FormulaVariable variables_along[] = {{"phi", "rad"}, {"w", "rad/s"}, {"s", "m"}, {"v", "m/s"}};

// A force that an expression gives, of which the inputs are the signals that it names (field/formula.h):
//   formula()             the expression
//   decide(q, v, u, g)    what decides on its branches
//   reads_speed()         whether it depends on v
template <class F>
concept HasFormula = requires(const F& f) { f.formula(); };

// The error of bounds that leave no room to the coordinate; otherwise empty.
inline std::optional<ElementFault> fault_of_bounds(double lower, double upper, const Coordinate& at) {
  if (!(lower >= upper)) return {};
  const auto shown = [&](double x) { return text::with_unit(text::number(x), spelled(unit_of("{q}", at))); };
  return {{"lower", shown(lower), "less than upper, which is " + shown(upper)}};
}

}  // namespace gelenk
