// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// The equations that controllers of an error with this unit share; rest: the terms that are added to gain*error.
template <class Controller>
void describe_controller(ComponentEquations& of, std::string_view error, std::string_view unit, std::string_view rest,
                         const Controller& with) {
  const bool integrates = is_given(with.reset_time);
  const bool is_limited = is_given(with.limit);
  const bool is_fed = with.feedforward.is_given();
  if (is_fed) of.signal({"feedforward", "{f}", "{torque} that is added before the limit"}, with.feedforward);
  of.value({"error", unit, "difference from the target"}, {error});
  of.value({"wanted", "{f}", "{torque} without its limit"},
           {"gain*error", rest, integrates ? " + integral" : "", is_fed ? " + feedforward" : ""});
  of.act({is_limited ? "clip(wanted, -limit, limit)" : "wanted"});
  if (!integrates) return;
  const bool is_given_tracking = is_given(with.tracking_time);
  of.state({"integral", "{f}", "{torque} by the integral of the error"},
           {"gain*error/reset_time", !is_limited         ? ""
                                     : is_given_tracking ? " + ({effort} - wanted)/tracking_time"
                                                         : " + ({effort} - wanted)/reset_time"});
}

}  // namespace gelenk
