// SPDX-License-Identifier: BSD-3-Clause
// A list for each kind of element, instead of one list of variants.
#pragma once

#include <tuple>
#include <utility>

namespace gelenk {

// Calls visit(list) for the list of each kind. Inline: most lists are empty, in every evaluation.
template <class L, class Visit>
[[gnu::always_inline]] inline void each_list(L& lists, Visit&& visit) {
  std::apply([&](auto&... list) __attribute__((always_inline)) { (visit(list), ...); }, lists);
}
template <class L>
bool all_empty(const L& lists) {
  return std::apply([](const auto&... list) { return (list.empty() && ...); }, lists);
}

}  // namespace gelenk
