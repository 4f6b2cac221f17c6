// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <vector>

namespace gelenk {

// Whether as many numbers at x are the same as these bitwise, so that a run does not depend on what was computed
// before. Most differ in their first number.
inline bool bitwise_equal(const double* x, const std::vector<double>& as) {
  return as.empty() || (*x == as.front() && std::memcmp(x, as.data(), as.size() * sizeof *x) == 0);
}

}  // namespace gelenk
