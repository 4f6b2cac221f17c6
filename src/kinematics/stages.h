// SPDX-License-Identifier: BSD-3-Clause
// Cache control by stages (Sherman, Seth & Delp 2011, "realization"). Each stage depends on the earlier ones: realizing
// a stage again invalidates the later stages and everything that was computed at it.
#pragma once

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
  void clear() { realized_ = 0; }
  // How often the stage has been realized.
  long times(Stage stage) const { return times_[static_cast<std::size_t>(stage)]; }

 private:
  int realized_ = 0;  // number of valid stages
  std::array<long, 3> times_{};
};

// Validity of a quantity that is computed after a stage: it holds until the stage is realized again.
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
