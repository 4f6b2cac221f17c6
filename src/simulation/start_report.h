// SPDX-License-Identifier: BSD-3-Clause
// What assembly made of a simulation's scene.
#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// Of a simulation that outlives it, from initialize() on.
class StartReport {
 public:
  explicit StartReport(const Simulation& of) : impl_(*of.impl_) {}

  // What assembly found, in words: the branch (start values of every joint) and what it changed.
  const std::string& assembly() const;
  // What is doubtful about the start, a sentence each: singular configurations.
  const std::vector<std::string>& warnings() const;
  // Joint frames that were moved so that loops with rounded numbers close; and the scene with these, in SI.
  std::vector<MovedFrame> moved_frames() const;
  Scene adjusted_scene() const;
  // The scene as it is reduced and stands at its start.
  const PreparedScene& prepared() const;

 private:
  const Simulation::Impl& impl_;
};

}  // namespace gelenk
