// SPDX-License-Identifier: BSD-3-Clause
// Communication points as counted steps: t = origin + n h. Masters sum their time, or multiply, or take differences,
// each with its own rounding; the plant sees the same instants from all of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "util/archive.h"

namespace gelenk {

class Clock {
 public:
  // The next step begins at `time` [s], and so does the count.
  void start(double time) {
    *this = {};
    end_ = time;
  }

  // Whether a step of size h may begin at the master's time `current`: where the last one ended, up to the rounding
  // of the two clocks: 1e-9 of a step, and 16 units in the last place.
  bool meets(double current, double h) const {
    const double ulp = std::numeric_limits<double>::epsilon() * std::max(std::abs(current), std::abs(end_));
    return std::abs(current - end_) <= 1e-9 * h + 16 * ulp;
  }

  // Where that step ends [s]; to be called for steps that meet.
  double step(double current, double h) {
    const double counted = origin_ + (count_ + 1) * size_;
    const bool same = std::abs(h - size_) <= 1e-9 * h && std::abs(counted - (current + h)) <= 1e-9 * h;
    if (!same) {
      origin_ = current;
      count_ = 0;
      size_ = h;
    }
    ++count_;
    end_ = current + h;
    return origin_ + count_ * size_;
  }

  void serialize(Archive& archive) { archive.serialize(origin_, size_, count_, end_); }

  // The master's time at the end of the last step.
  double end() const { return end_; }

 private:
  double origin_ = 0;
  double size_ = std::numeric_limits<double>::quiet_NaN();
  double count_ = 0;  // whole
  double end_ = 0;
};

}  // namespace gelenk
