// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// In place of the mode of a force with modes: that of the state; and friction without effect.
inline constexpr int mode_of_state = 2;
inline constexpr int mode_released = 3;

}  // namespace gelenk
