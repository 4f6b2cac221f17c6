// SPDX-License-Identifier: BSD-3-Clause
// Quantities given as functions of time: the inputs and the targets of the coordinate rows.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "formulation/inputs.h"
#include "formulation/targets.h"

namespace gelenk {

class Drives {
 public:
  Drives(const Mechanism& mechanism, Dynamics& dynamics, Inputs& inputs);

  // Evaluates the inputs and the time-dependent targets at t [s].
  void go_to(double t);
  // The same for outputs at the present time of the run: derivatives are those of the motion that has led there
  // (Inputs::rate).
  void go_to_outputs(double t);
  // During its lifetime outputs show motions as the step that ends there does, before the inputs have been brought to
  // its end.
  class AtEndOfStep {
   public:
    explicit AtEndOfStep(Drives& drives) : drives_(drives) { drives_.is_at_end_of_step_ = true; }
    ~AtEndOfStep() { drives_.is_at_end_of_step_ = false; }
    AtEndOfStep(const AtEndOfStep&) = delete;
    AtEndOfStep& operator=(const AtEndOfStep&) = delete;

   private:
    Drives& drives_;
  };

  // Inputs at the time evaluated last.
  const std::vector<double>& u() const { return inputs_.now(); }
  int count() const { return static_cast<int>(inputs_.signals()); }
  const Inputs& inputs() const { return inputs_; }

  // Target of a coordinate row and its derivatives at t, the present time of the run (Targets::derivatives).
  MotionLaw::Derivatives target(int row, double t) const { return targets_.derivatives(row, t, inputs_); }
  // s and ds/dt of each coordinate row at t.
  void targets_at(double t, std::vector<double>& out);

 private:
  Dynamics& dynamics_;
  Inputs& inputs_;
  Targets targets_;
  std::size_t rows_;
  bool is_at_end_of_step_ = false;
};

}  // namespace gelenk
