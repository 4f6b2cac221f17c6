// SPDX-License-Identifier: BSD-3-Clause
// What Code::function computes of one number.
#pragma once

#include <cmath>

#include "expression/functions.h"

namespace gelenk::lanes {

// y: of functions of two arguments.
inline double library_function(expression::Operation function, double x, double y) {
  switch (function) {
    case expression::Operation::atan2:
      return std::atan2(x, y);
    case expression::Operation::power:
      return std::pow(x, y);
    default:
      return expression::value_at(function, x);
  }
}

}  // namespace gelenk::lanes
