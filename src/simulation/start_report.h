// SPDX-License-Identifier: BSD-3-Clause
// Results of the assembly of a simulation.
#pragma once

#include <string>
#include <vector>

#include "preparation/adjustment.h"
#include "preparation/preparation.h"
#include "simulation/simulation.h"

namespace gelenk {

// View of a simulation that outlives it. Requires initialize() or assemble().
class StartReport {
 public:
  explicit StartReport(const Simulation& of) : impl_(*of.impl_) {}

  // A sentence about the assembly found: the start values of all joints and how far guesses were moved.
  const std::string& assembly() const;
  // Warnings about the start, a sentence each, for example about singular configurations.
  const std::vector<std::string>& warnings() const;
  // Joint frames that were moved so that loops with rounded dimensions close [m, rad], and the scene with these frames,
  // in SI units.
  std::vector<MovedFrame> moved_frames() const;
  Scene adjusted_scene() const;
  // Parts without degrees of freedom, which are not integrated.
  int kinematic_parts() const;
  // The reduced scene with its islands at their start.
  const PreparedScene& prepared() const;

 private:
  const Simulation::Impl& impl_;
};

}  // namespace gelenk
