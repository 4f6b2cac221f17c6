// SPDX-License-Identifier: BSD-3-Clause
// Quantities given as functions of time: the inputs and the targets of the coordinate rows.
#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/dynamics.h"
#include "formulation/inputs.h"
#include "formulation/targets.h"
#include "kinematics/loads.h"

namespace gelenk {

class Drives {
 public:
  Drives(const Mechanism& mechanism, Dynamics& dynamics, Inputs& inputs, const Loads& loads);

  // Evaluates the inputs and the targets at t [s], under the element states set last.
  void go_to(double t);
  // The same, and sets the element states to those in y = (q, v, states).
  void go_to(double t, const double* y);
  // Number of element states, which follow (q, v) in y, and the index of the first one in u().
  int states() const { return states_; }
  int motion_size() const { return first_; }  // of (q, v)
  int first_state() const { return count() - states_; }
  void set_states(const double* states) { std::copy_n(states, states_, signals_.end() - states_); }
  // The same for outputs at the present time of the run: derivatives are those of the motion that has led there
  // (Inputs::rate).
  void go_to_outputs(double t, const double* y);
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

  // Inputs and clock at the time evaluated last, and the element states set last.
  const std::vector<double>& u() const { return states_ == 0 ? inputs_.now() : signals_; }
  int count() const { return static_cast<int>(inputs_.signals()) + states_; }
  // The same with other inputs.
  const std::vector<double>& u(const Inputs& others);
  const Inputs& inputs() const { return inputs_; }
  // Brings the signals on which laws of joints depend to those at y, after go_to(). Returns whether they may change.
  bool bring_signals(const double* y);

  // Target of a coordinate row and its derivatives at t, the present time of the run (Targets::derivatives).
  MotionLaw::Derivatives target(int row, double t) const { return targets_.derivatives(row, t, inputs_, u().data()); }
  // Whether targets depend on element states.
  bool targets_follow_states() const { return targets_follow_states_; }
  // See EventSource.
  bool has_breaks() const { return targets_.has_breaks(); }
  double next_break(double t) const { return targets_.next_break(t); }
  void begin_stretch(double from, double to) { targets_.begin_stretch(from, to); }
  // s and ds/dt of each coordinate row at t.
  void targets_at(double t, std::vector<double>& out);

 private:
  Dynamics& dynamics_;
  Inputs& inputs_;
  Targets targets_;
  std::size_t rows_;
  int coordinates_, states_, first_;  // nq; number of element states, and the index of the first one in y
  std::size_t named_;                 // number of quantities of the motion that expressions name
  bool targets_follow_states_;
  std::vector<double> signals_, others_;  // empty if there are no element states
  bool is_at_end_of_step_ = false;
};

}  // namespace gelenk
