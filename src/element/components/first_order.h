// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A filter of first order: T y' = u - y.
struct FirstOrder {
  static constexpr std::string_view kind = "first_order";
  static constexpr std::string_view summary = "a filter of first order";
  static constexpr std::span<const Port> ports = {};

  Formula input;
  double time_constant = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&FirstOrder::input>(free_signal_info(
                                        "input", "", "signal to filter, an expression; an input if not given")),
                                    field<&FirstOrder::time_constant>({.name = "time_constant",
                                                                       .unit = "s",
                                                                       .text = "time constant",
                                                                       .range = Range::positive,
                                                                       .required = true})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"input", "", "signal to filter"}, input);
    of.state({"y", "", "filtered signal"}, {"(input - y)/time_constant"});
  }
};

}  // namespace gelenk
