// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A limit of the rate of a signal: y follows u with the time constant T, but no faster than the limits permit.
struct RateLimiter {
  static constexpr std::string_view kind = "rate_limiter";
  static constexpr std::string_view summary = "a signal that follows another one with a limited rate";
  static constexpr std::span<const Port> ports = {};

  Formula input;
  double rise = 0;
  double fall = NAN;
  double time_constant = 1e-3;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&RateLimiter::input>(
            free_signal_info("input", "", "signal to follow, an expression; an input if not given")),
        field<&RateLimiter::rise>(
            {.name = "rise", .unit = "1/s", .text = "largest rising rate", .range = Range::positive, .required = true}),
        field<&RateLimiter::fall>({.name = "fall",
                                   .unit = "1/s",
                                   .text = "largest falling rate, as a positive number; rise if not given",
                                   .range = Range::positive,
                                   .optional = true}),
        field<&RateLimiter::time_constant>(
            {.name = "time_constant", .unit = "s", .text = "time constant near the signal", .range = Range::positive})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"input", "", "signal to follow"}, input);
    of.state({"y", "", "limited signal"},
             {"clip((input - y)/time_constant, -", is_given(fall) ? "fall" : "rise", ", rise)"});
  }
};

}  // namespace gelenk
