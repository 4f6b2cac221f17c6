// SPDX-License-Identifier: BSD-3-Clause
// What dry friction does where derivatives are taken.
#pragma once

#include <vector>

#include "event_driven/contact_equations.h"

namespace gelenk {

// What it does there; nothing moves; everything moves, and what is at rest moves against a constant friction; nothing.
enum class FrictionTreatment { present, locked, sliding, off };

// The modes of contacts in which derivatives are taken.
struct ContactHold {
  std::vector<CandidateMode> modes{};  // by candidate; empty: all are open
  bool without_friction = false;
};

}  // namespace gelenk
