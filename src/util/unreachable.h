// SPDX-License-Identifier: BSD-3-Clause
// What C++23 has in <utility>.
#pragma once

#include <cstdlib>

namespace gelenk {

// Where no run comes; the compiler may count on it.
[[noreturn]] inline void unreachable() {
#if defined(__GNUC__)
  __builtin_unreachable();
#elif defined(_MSC_VER)
  __assume(false);
#else
  std::abort();
#endif
}

}  // namespace gelenk
