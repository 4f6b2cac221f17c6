// SPDX-License-Identifier: BSD-3-Clause
#include "batch/numbers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "recording/recorded.h"

namespace gelenk {
namespace {

// Relative to their own size, which may be small: moments of inertia of small parts are, in kg m2.
bool is_constant(double before, double after) {
  return std::abs(before - after) <= 1e-13 * std::max(std::abs(before), std::abs(after));
}

// Positions that are assembled differ by rounding from scene to scene.
bool is_same(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(1.0, std::abs(a)); }

}  // namespace

NumberedScene numbered(const Scene& scene) {
  const recording::NumberList list;
  NumberedScene out;
  out.scene = std::make_unique<TracedScene>(scene);
  out.numbers = list.numbers();
  return out;
}

VariedNumbers::VariedNumbers(const std::vector<double>& numbers, const std::vector<double>& changed)
    : numbers_(numbers), variables_(numbers.size(), -1) {
  std::map<std::pair<double, double>, int> known;
  for (std::size_t i = 0; i < std::min(numbers.size(), changed.size()); ++i) {
    if (is_constant(numbers[i], changed[i])) continue;
    const auto [at, is_new] = known.try_emplace({numbers[i], changed[i]}, first_variable + count());
    if (is_new) places_.push_back(i);
    variables_[i] = at->second;
  }
}

bool VariedNumbers::find(const std::vector<double>& numbers, double* values) const {
  if (numbers.size() != numbers_.size()) return false;
  for (std::size_t k = 0; k < places_.size(); ++k) values[k] = numbers[places_[k]];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const int variable = variables_[i];
    if (!is_same(variable < 0 ? numbers_[i] : values[variable - first_variable], numbers[i])) return false;
  }
  return true;
}

}  // namespace gelenk
