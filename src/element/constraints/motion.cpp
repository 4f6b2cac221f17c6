// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "util/text.h"

namespace gelenk {

std::optional<ElementFault> Motion::fault(const Coordinate&) const {
  if (table) return fault(*table);
  if (!law_of_time.is_given() || follows_signals()) return {};
  if (has_kinks(law_of_time)) {
    return {{"law", text::quoted(law_of_time.text()) + ", which has kinks (abs, sign, min, max, clip, smoothstep, if)",
             "a smooth expression: at a kink of a prescribed motion, the acceleration or the speed would jump"}};
  }
  try {
    if (!law()->is_steady())
      return {{"law", text::quoted(law_of_time.text()) + ", whose speed would jump",
               "tables of a*t + b with the interpolation pchip, akima or spline, and another extrapolation than hold "
               "unless their derivatives at the ends are 0"}};
  } catch (const std::length_error&) {
    return {{"law", "an expression of " + std::to_string(law_of_time.text().size()) + " characters",
             "a shorter one: its derivatives have too many terms"}};
  }
  return {};
}

std::optional<ElementFault> Motion::doubt() const {
  const std::string overshoot = table ? expression::Table(table->data()).doubt() : "";
  if (overshoot.empty()) return {};
  return {{"table", overshoot, "interpolation: pchip, whose acceleration jumps at the points, or more points"}};
}

std::optional<ElementFault> Motion::fault(const TimeTable& table) {
  constexpr double end_tolerance = 1e-12;  // of a periodic table, relative: rounding of the decimal numbers in the file
  const std::vector<double>& t = table.time;
  const std::vector<double>& s = table.value;
  if (t.size() != s.size()) {
    return {{"table", std::to_string(t.size()) + " times and " + std::to_string(s.size()) + " values",
             "equally many times and values, at least 2"}};
  }
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] > t[i - 1]) continue;
    return {{"table.time[" + std::to_string(i + 1) + "]", text::number(t[i]) + " s",
             "more than the previous time, " + text::number(t[i - 1]) + " s"}};
  }
  double max_value = 0;
  for (const double x : s) max_value = std::max(max_value, std::abs(x));
  if (!table.periodic || std::abs(s.back() - s.front()) <= end_tolerance * max_value) return {};
  return {{"table.value[" + std::to_string(s.size()) + "]", text::number(s.back()),
           "the first value, " + text::number(s.front()) + ", since the table is periodic"}};
}

}  // namespace gelenk
