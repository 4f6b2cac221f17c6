// SPDX-License-Identifier: BSD-3-Clause
// Replacement for std::unreachable of C++23.
#pragma once

#include <cstdlib>

namespace gelenk {

// Marks code that is never executed; the compiler may assume this.
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
