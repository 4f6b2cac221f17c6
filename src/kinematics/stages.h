// SPDX-License-Identifier: BSD-3-Clause
// What has been computed of a state, by stages (Sherman, Seth & Delp 2011, "realization"). Each stands on those before
// it: to realize one anew leaves those after it, and all that was computed at it, out of date, so that nothing has to
// be marked by hand.
#pragma once

#include <algorithm>
#include <array>

#include "element/element.h"

namespace gelenk {

class Stages {
 public:
  bool has(Stage stage) const { return realized_ > static_cast<int>(stage); }
  void realize(Stage stage) {
    realized_ = static_cast<int>(stage) + 1;
    ++times_[static_cast<std::size_t>(stage)];
  }
  // What later stages had left behind has been overwritten.
  void fall_back_to(Stage stage) { realized_ = std::min(realized_, static_cast<int>(stage) + 1); }
  void clear() { realized_ = 0; }
  // How often it has been realized.
  long times(Stage stage) const { return times_[static_cast<std::size_t>(stage)]; }

 private:
  int realized_ = 0;  // stages, from the first on
  std::array<long, 3> times_{};
};

// Whether something was computed since a stage was realized.
class Computed {
 public:
  explicit Computed(Stage from) : from_(from) {}
  bool holds(const Stages& stages) const { return stages.has(from_) && at_ == stages.times(from_); }
  void set(const Stages& stages) { at_ = stages.times(from_); }
  void drop() { at_ = -1; }

 private:
  Stage from_;
  long at_ = -1;
};

}  // namespace gelenk
