// SPDX-License-Identifier: BSD-3-Clause
// Communication points as counted steps, t = origin + n h. Masters compute their time by sums, products or differences,
// with different rounding errors; this way the plant sees the same times from all of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "util/archive.h"

namespace gelenk {

class Clock {
 public:
  // Restarts the count at `time` [s], the start of the next step.
  void start(double time) {
    *this = {};
    end_ = time;
  }

  // Whether a step of size h may begin at the master's time `current`, that is, at the end of the last one up to
  // rounding errors: 1e-9 of a step plus 16 units in the last place.
  bool continues_at(double current, double h) const {
    const double ulp = std::numeric_limits<double>::epsilon() * std::max(std::abs(current), std::abs(end_));
    return std::abs(current - end_) <= 1e-9 * h + 16 * ulp;
  }

  // Makes this step and returns its end [s]. Requires continues_at(current, h).
  double step(double current, double h) {
    const double counted = origin_ + (count_ + 1) * size_;
    const bool continues_count = std::abs(h - size_) <= 1e-9 * h && std::abs(counted - (current + h)) <= 1e-9 * h;
    if (!continues_count) {
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
  double count_ = 0;  // an integer
  double end_ = 0;
};

}  // namespace gelenk
