// SPDX-License-Identifier: BSD-3-Clause
// Why a run may not have kept its tolerance: time steps with impulses, and events of which the outcome is uncertain.
#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// View of a simulation that outlives it. Requires initialize() or assemble().
class SteppingReport {
 public:
  explicit SteppingReport(const Simulation& of) : impl_(*of.impl_) {}

  // Sentences, for each island: the first events with an uncertain outcome; where `auto` has left located events, from
  // when to when, the estimated error of positions, and why.
  std::vector<std::string> warnings() const;

 private:
  const Simulation::Impl& impl_;
};

}  // namespace gelenk
