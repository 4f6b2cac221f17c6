// SPDX-License-Identifier: BSD-3-Clause
// Numbers that the parts of a decision on contacts share.
#pragma once

namespace gelenk {

// Of friction that reaches its limit, this fraction counts as slipping, so that what breaks away at the same instant
// does so together; and what the solution of a cone problem may be short of a limit.
inline constexpr double break_away_fraction = 1e-9;
inline constexpr double limit_fraction = 1e-10;
// Normal forces below this fraction of the largest are none.
inline constexpr double least_force = 1e-9;
// Errors of accelerations relative to the largest, where a solution is checked.
inline constexpr double acceleration_tolerance = 1e-8;

}  // namespace gelenk
