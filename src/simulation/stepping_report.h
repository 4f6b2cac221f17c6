// SPDX-License-Identifier: BSD-3-Clause
// Where `auto` has left located events for time steps with impulses during a run.
#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// View of a simulation that outlives it. Requires initialize() or assemble().
class SteppingReport {
 public:
  explicit SteppingReport(const Simulation& of) : impl_(*of.impl_) {}

  // A sentence for each island in which it has: from when to when, the estimated error of positions, and why.
  std::vector<std::string> warnings() const;

 private:
  const Simulation::Impl& impl_;
};

}  // namespace gelenk
