// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A filter of second order: y'' = w0^2 (u - y) - 2 D w0 y'.
struct SecondOrder {
  static constexpr std::string_view kind = "second_order";
  static constexpr std::string_view summary = "a filter of second order, with the rate of its output";
  static constexpr std::span<const Port> ports = {};

  Formula input;
  double natural_frequency = 0;
  double damping_ratio = 1;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SecondOrder::input>(
            free_signal_info("input", "", "signal to filter, an expression; an input if not given")),
        field<&SecondOrder::natural_frequency>({.name = "natural_frequency",
                                                .unit = "rad/s",
                                                .text = "natural frequency",
                                                .range = Range::positive,
                                                .required = true}),
        field<&SecondOrder::damping_ratio>(
            {.name = "damping_ratio", .unit = "1", .text = "damping ratio", .range = Range::not_negative})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"input", "", "signal to filter"}, input);
    of.state({"y", "", "filtered signal"}, {"rate"});
    of.state({"rate", "1/s", "rate of the filtered signal"},
             {"natural_frequency^2*(input - y) - 2*damping_ratio*natural_frequency*rate"});
  }
};

}  // namespace gelenk
