// SPDX-License-Identifier: BSD-3-Clause
// The state within a step, by a polynomial of order 4 in time.
//
// Each component is the cubic through its values and rates at both ends (Hermite), plus a multiple of s^2 (1 - s)^2, of
// the fraction s of the step, that the rates at a quarter of the step determine. Where it is small, what is still
// missing is smaller than the error of any method. Where the state consists of coordinates and their rates, the
// coordinates are the integrals of these.
#pragma once

#include <cstddef>
#include <vector>

#include "event/event_source.h"

namespace gelenk {

class StepPolynomial {
 public:
  // size: number of components of y.
  explicit StepPolynomial(int size)
      : y0_(static_cast<std::size_t>(size)), y1_(y0_), rate0_(y0_), rate1_(y0_), bump_(y0_), work_(y0_) {}

  // Of the step from (t0, y0) to (t1, y1) in the held mode; returns whether it is that accurate.
  bool set(EventSource& source, double t0, const double* y0, double t1, const double* y1);
  // The state at t within the step; quaternions are not normalized.
  void at(double t, double* y) const;

 private:
  bool consists_of_coordinates_and_rates() const;
  bool find_bumps(EventSource& source);
  double integral(std::size_t k, double s) const;

  double t0_ = 0, h_ = 0;    // s
  bool integrates_ = false;  // whether the second half of the components are the rates of the first
  std::vector<double> y0_, y1_, rate0_, rate1_;
  std::vector<double> bump_;  // by component: the multiple of s^2 (1 - s)^2
  std::vector<double> work_;
};

}  // namespace gelenk
