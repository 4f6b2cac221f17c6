// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace gelenk {

// The bound of what has none.
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

}  // namespace gelenk
