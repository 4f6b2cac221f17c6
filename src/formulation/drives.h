// SPDX-License-Identifier: BSD-3-Clause
// What is given as functions of time: the inputs, and what coordinate rows are to be.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "formulation/inputs.h"
#include "formulation/targets.h"

namespace gelenk {

class Drives {
 public:
  Drives(const Mechanism& mechanism, Dynamics& dynamics, Inputs& inputs);

  // Takes the inputs, and the rows that change with time, to t.
  void go_to(double t);
  // The same where the run stands, for outputs: of the motion that has led there (Inputs::rate).
  void go_to_outputs(double t);

  // At the time that was evaluated last.
  const std::vector<double>& u() const { return inputs_.now(); }
  int count() const { return static_cast<int>(inputs_.count()); }
  const Inputs& inputs() const { return inputs_; }

  // What a coordinate row is to be at t, where the run stands (Targets::derivatives).
  MotionLaw::Derivatives target(int row, double t) const { return targets_.derivatives(row, t, inputs_); }
  // s and ds/dt of each coordinate row at t.
  void targets_at(double t, std::vector<double>& out);

 private:
  Dynamics& dynamics_;
  Inputs& inputs_;
  Targets targets_;
  std::size_t rows_;
};

}  // namespace gelenk
