// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "event_driven/mode_equations.h"
#include "scene/signals.h"

namespace gelenk {

// Counts since the start of a run; those of contacts are of the last step, or the last communication step.
struct RunCounts : ModeCounts {
  long steps = 0, rejected_steps = 0, evaluations = 0, jacobians = 0, traced = 0, events = 0, singular_positions = 0;
  long contact_points = 0, cone_iterations = 0, scheme = 0;
  double cone_residual = 0;  // natural units of speed
  double step_error = 0;     // of steps with impulses of `auto` [rad, natural units of length]

  // The count that a diagnostic sums over all islands; 0: of another diagnostic.
  long of(Diagnostic diagnostic) const {
    switch (diagnostic) {
      case Diagnostic::steps:
        return steps;
      case Diagnostic::rejected_steps:
        return rejected_steps;
      case Diagnostic::evaluations:
        return evaluations;
      case Diagnostic::jacobians:
        return jacobians;
      case Diagnostic::traced:
        return traced;
      case Diagnostic::singular_positions:
        return singular_positions;
      case Diagnostic::events:
        return events;
      case Diagnostic::impacts:
        return impacts;
      case Diagnostic::zeno:
        return closed_series;
      case Diagnostic::ambiguous:
        return ambiguous;
      case Diagnostic::contact_points:
        return contact_points;
      default:
        return 0;
    }
  }
};

}  // namespace gelenk
