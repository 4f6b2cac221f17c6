// SPDX-License-Identifier: BSD-3-Clause
// What acts along a coordinate of a joint, in the user's sense. It offers
//
//   effort(q, v, u)     tau [N m, N] on the coordinate q [rad, m] with the speed v; u: its own inputs
//   slopes(q, v)        its derivatives by q and v; may be left out: dual numbers serve
//   energy(q)           J, stored in it; may be left out
//   inertia()           kg m2 (kg) that it adds to the coordinate; may be left out
//   is_idle()           whether with these numbers it does nothing; may be left out
//   of what has branches: side(q, v), that on which the state lies: 1, -1 or 0;  held(side, q, v), the effort on one
//                       that is held, by which effort is not asked for;  indicators(q, v, g, gdot), what vanishes where
//                       side 1 and side -1 begin and end;  events[2][2], of each in words what happens where it becomes
//                       negative, and positive
//   doubt(q, coordinate)   what is doubtful about a start at q; may be left out
//
// A joint's own, which stand among the joint's fields (a spring, a damper), say in group the name of the mapping that
// they stand in, or nothing, and in fits(kind) which joints can have them.
#pragma once

#include "element/element.h"

namespace gelenk {

template <class F>
concept HasBranches = requires(const F& f, double x) { f.side(x, x); };

}  // namespace gelenk
