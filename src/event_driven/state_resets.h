// SPDX-License-Identifier: BSD-3-Clause
// Jumps of element states at the instants at which conditions become true.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "dynamics/dynamics.h"
#include "event_driven/mode_equations.h"
#include "util/archive.h"

namespace gelenk {

struct Loads;

class StateResets {
 public:
  // All must outlive it. nq, nv: of the state (q, v, element states).
  StateResets(const Loads& loads, Dynamics& dynamics, ModeEquations& equations, int nq, int nv);

  // Conditions that hold at the start cause no jump.
  void start(double t, const double* y);
  // Lets the states in y jump whose conditions have become true since the last call, by the first of their resets;
  // returns whether one has. What becomes true by a jump causes one at the same instant.
  bool apply(double t, double* y);
  // Why the run cannot continue: states would jump again and again at the same instant, or to no number; empty: it can.
  std::string_view refusal() const { return refusal_; }
  void refuse_repetition() { refusal_ = repetition; }
  void serialize(Archive& archive);

 private:
  static constexpr std::string_view repetition =
      "resets of element states cause each other again and again at one instant";

  void evaluate(double t, const double* y);

  const Loads& loads_;
  Dynamics& dynamics_;
  ModeEquations& equations_;
  int nq_;
  std::size_t first_state_;
  std::vector<double> vdot_, g_, gdot_;
  std::unique_ptr<bool[]> positive_;  // by branch of expressions
  std::vector<char> held_;            // by reset: whether its condition held at the last call
  std::vector<double> when_, to_;
  std::string_view refusal_;
};

}  // namespace gelenk
