// SPDX-License-Identifier: BSD-3-Clause
// Communication steps of co-simulation.
#pragma once

#include <initializer_list>

#include "fmu/place.h"
#include "fmu/status.h"

namespace gelenk {

struct CommunicationStep {
  double start, size;  // s
};

// What FMI 3.0 reports about a step.
struct StepResult {
  bool is_early;        // the step ended before its end, from where the next one continues
  bool is_futile;       // a retry can only succeed with other inputs
  double time_reached;  // s
};

// function: that of FMI, for messages. places: for the results, which must not be null. result: as far as the call is
// not refused.
Status do_step(void* instance, const char* function, CommunicationStep step, std::initializer_list<Place> places,
               StepResult& result) noexcept;

}  // namespace gelenk
