// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "nonsmooth/shared_load.h"

namespace gelenk {

class TimeStepper;

// A load on which the motion depends and that a point of contact shared with joints at rest in a step. View of a
// stepper that outlives it.
class SharedImpulses {
 public:
  explicit SharedImpulses(const TimeStepper& of) : of_(of) {}
  // Of the last step, unless something was struck in it.
  std::optional<SharedLoad> find() const;

 private:
  struct Kept;
  bool may_share() const;
  bool presses(std::size_t point) const;
  bool holds(std::size_t joint) const;
  void keep_connected(std::vector<char>& cones) const;
  void add_point(std::size_t point, Kept& to) const;
  void add_joint(std::size_t joint, Kept& to) const;

  const TimeStepper& of_;
};

}  // namespace gelenk
