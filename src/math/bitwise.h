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

// Whether all bits are the same. T: numbers without gaps between them, such as matrices of fixed size.
template <class T>
bool is_bitwise_equal(const T& a, const T& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): 0 and -0 differ
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace gelenk
