// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a scene in its equations. A parameter reaches them through checks, reductions and preparations that
// compute with doubles: so the equations are recorded again with other values of the parameters, and what is a constant
// of one recording and another one of the next depends on the parameters.
#pragma once

#include <memory>
#include <vector>

#include "equations/scene_equations.h"
#include "scene/scene.h"

namespace gelenk {

// The equations of a scene, and the numbers that became constants in them, in the order of NumberList.
struct NumberedScene {
  std::unique_ptr<TracedScene> scene;
  std::vector<double> numbers;
};
// Throws what TracedScene throws.
NumberedScene numbered(const Scene& scene);

// Which of these numbers are variables.
class VariedNumbers {
 public:
  // The variables of the equations of which the index is at least this one are numbers of the scene.
  static constexpr int first_variable = 1 << 20;

  // changed: the numbers after all parameters that may vary have changed. Those that are equal before and after are one
  // variable.
  VariedNumbers(const std::vector<double>& numbers, const std::vector<double>& changed);

  int count() const { return static_cast<int>(places_.size()); }
  // By place in the list, as for NumberList.
  const std::vector<int>& variables() const { return variables_; }
  // The values of the variables among the numbers of another scene. False: it differs from the first one in more.
  bool find(const std::vector<double>& numbers, double* values) const;

 private:
  std::vector<double> numbers_;
  std::vector<int> variables_;
  std::vector<std::size_t> places_;  // by variable: the first place
};

}  // namespace gelenk
