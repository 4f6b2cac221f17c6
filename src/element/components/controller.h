// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// What controllers share.
inline constexpr FieldInfo feedforward_info =
    signal_info("feedforward", "{f}", "{torque} that is added before the limit, an expression; none if not given");
inline constexpr FieldInfo reset_time_info = {
    .name = "reset_time",
    .unit = "s",
    .text = "integral time: a constant error adds its proportional part again in this time; no integral if not given",
    .range = Range::positive,
    .optional = true};
inline constexpr FieldInfo limit_info = {.name = "limit",
                                         .unit = "{f}",
                                         .text = "limit of the {torque} in both directions",
                                         .range = Range::positive,
                                         .optional = true};
inline constexpr FieldInfo tracking_time_info = {
    .name = "tracking_time",
    .unit = "s",
    .text = "time constant of the back-calculation at the limit (anti-windup); reset_time if not given",
    .range = Range::positive,
    .optional = true};

// The equations that controllers of an error with this unit share; rest: the terms that are added to gain*error.
template <class Controller>
void describe_controller(ComponentEquations& of, std::string_view error, std::string_view unit, std::string_view rest,
                         const Controller& with) {
  const bool integrates = is_given(with.reset_time);
  const bool is_limited = is_given(with.limit);
  const bool is_fed = with.feedforward.is_given();
  if (is_fed) of.signal({"feedforward", "{f}", "{torque} that is added before the limit"}, with.feedforward);
  of.value({"error", unit, "difference from the target"}, {error});
  of.value({"unlimited", "{f}", "{torque} before the limit"},
           {"gain*error", rest, integrates ? " + integral" : "", is_fed ? " + feedforward" : ""});
  of.act({is_limited ? "clip(unlimited, -limit, limit)" : "unlimited"});
  if (!integrates) return;
  of.state({"integral", "{f}", "{torque} by the integral of the error"},
           {"gain*error/reset_time", !is_limited                    ? ""
                                     : is_given(with.tracking_time) ? " + ({effort} - unlimited)/tracking_time"
                                                                    : " + ({effort} - unlimited)/reset_time"});
}

}  // namespace gelenk
