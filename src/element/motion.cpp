// SPDX-License-Identifier: BSD-3-Clause
#include "element/motion.h"

#include <algorithm>
#include <cmath>

#include "util/text.h"

namespace gelenk {

std::optional<ElementFault> Motion::fault(const Table& table) {
  constexpr double same_value = 1e-12;  // the ends of a periodic table: as the file's digits tell them
  const std::vector<double>& t = table.time;
  const std::vector<double>& s = table.value;
  if (t.size() != s.size()) {
    return {{"table", std::to_string(t.size()) + " times and " + std::to_string(s.size()) + " values",
             "as many of both, 2 or more"}};
  }
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] > t[i - 1]) continue;
    return {{"table.time[" + std::to_string(i + 1) + "]", text::number(t[i]) + " s",
             "more than the time before, " + text::number(t[i - 1]) + " s"}};
  }
  double size = 0;
  for (const double x : s) size = std::max(size, std::abs(x));
  if (!table.periodic || std::abs(s.back() - s.front()) <= same_value * size) return {};
  return {{"table.value[" + std::to_string(s.size()) + "]", text::number(s.back()),
           "the first value, " + text::number(s.front()) + ", as the table is periodic"}};
}

}  // namespace gelenk
