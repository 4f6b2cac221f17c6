// SPDX-License-Identifier: BSD-3-Clause
// Redundant forces that keep joints and contacts at rest, which laws permit in one distribution and not in another:
// what indicators and outputs show of them, the part of ModeChanges for reading.
#include <algorithm>
#include <limits>

#include "event_driven/mode_changes.h"

namespace gelenk {

void ModeChanges::redistribute(double t, const double* y, double* joints, double* contacts) {
  redistributed_ = false;
  if (contact_equations_.closed().empty()) return;
  std::vector<double*> yielding;
  contacts_.find_yielding(contacts, yielding);
  std::size_t kept = contact_equations_.closed().size();
  if (joints != nullptr) kept += joints_.find_yielding(joints, yielding);
  // A single contact has redundant forces where its body cannot move in all directions, as on a pendulum.
  const bool may_differ = kept > 1 || !contact_equations_.are_unique();
  if (yielding.empty() || !may_differ || !decisions_.hold_by_others(t, y)) return;
  redistributed_ = true;
  for (double* value : yielding) *value = *value > 0 ? -*value : std::max(-*value, std::numeric_limits<double>::min());
}

// Whether forces of the last accelerations are outside the laws of what is kept at rest.
bool ModeChanges::exceed_laws() {
  if (joints_.exceed_limits()) return true;
  contacts_.indicators_of_closed(vdot_.data(), checked_.data(), checked_rates_.data());
  std::vector<double*> yielding;
  contacts_.find_yielding(checked_.data(), yielding);
  return !yielding.empty();
}

void ModeChanges::record_outputs(double t, const double* y) {
  ContactOutputs& outputs = contacts_.outputs();
  if (!contact_equations_.closed().empty() && exceed_laws() && decisions_.hold_by_others(t, y)) {
    const Eigen::VectorXd distributed = decisions_.contact_forces();
    equations_.accelerations_at(t, y, vdot_.data());
    outputs.record(&distributed);
  } else {
    outputs.record(nullptr);
  }
  outputs.open_all();
}

}  // namespace gelenk
