// SPDX-License-Identifier: BSD-3-Clause
// The state over a step, interpolated from its ends: along straight lines, or by cubics once the rates are known there.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/cubic.h"

namespace gelenk {

class StateCourse {
 public:
  StateCourse(Dynamics& dynamics, int size) : dynamics_(dynamics), y_(static_cast<std::size_t>(size)) {
    for (auto* vectors : {&ends_, &rates_}) vectors->fill(std::vector<double>(y_.size()));
  }

  void set_ends(const double* y0, const double* y1) {
    std::copy_n(y0, y_.size(), ends_[0].begin());
    std::copy_n(y1, y_.size(), ends_[1].begin());
    step_ = 0;
  }
  // At the start (0) or the end (1), to be filled in before use_rates().
  double* rates(std::size_t end) { return rates_[end].data(); }
  void use_rates(double step) { step_ = step; }

  // s: fraction of the step. Valid until the next call.
  const double* at(double s) {
    for (std::size_t k = 0; k < y_.size(); ++k) {
      const double change = ends_[1][k] - ends_[0][k];
      const Cubic course(ends_[0][k], step_ > 0 ? step_ * rates_[0][k] : change, ends_[1][k],
                         step_ > 0 ? step_ * rates_[1][k] : change);
      y_[k] = course.value(s);
    }
    dynamics_.normalize(y_.data());
    return y_.data();
  }

 private:
  Dynamics& dynamics_;
  std::vector<double> y_;
  std::array<std::vector<double>, 2> ends_, rates_;
  double step_ = 0;  // s; 0: without rates
};

}  // namespace gelenk
