// SPDX-License-Identifier: BSD-3-Clause
// Kinks and jumps of laws that are given as expressions: where abs, min, if and the like change their branch. In a step
// each law stays on the branches on which it was at the start, on which it is smooth.
#pragma once

#include <span>
#include <string>

namespace gelenk {

class LawKinks {
 public:
  virtual ~LawKinks() = default;

  virtual int count() const = 0;
  // Whether rates of the indicators depend on accelerations.
  virtual bool need_accelerations() const = 0;
  // Whether a law with branches reads the time.
  virtual bool read_time() const = 0;
  // What decides on each branch at the current state, with the inputs of SwitchingForces::inputs(), and its rate; NaN
  // if that is unknown. vdot: the accelerations, or null.
  virtual void indicators(const double* vdot, double* g, double* gdot) = 0;
  // Holds the branches on which laws are where these indicators are positive; null: those of the state.
  virtual void hold(const bool* positive) = 0;
  virtual std::span<const bool> held() const = 0;  // empty: those of the state
  // How far the state is from the end of each held branch; negative: on another one.
  virtual void distances(double* out) = 0;
  // Whether the state is on other branches than the held ones, by more than rounding.
  virtual bool are_passed() = 0;
  // By reset of element states: 1 where its condition holds, on the held branches, otherwise 0; and the state after it.
  virtual void resets(double* when, double* to) = 0;
  // What is said of a table that has no value at the present state and time; empty: each has.
  virtual std::string missing_value() = 0;
};

}  // namespace gelenk
