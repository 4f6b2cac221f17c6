// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// The equations of motion as modes need them.
class ModeEquations {
 public:
  // vdot (nv) at (t, y) in the held modes, without effect on the run; `dynamics` is left there.
  virtual void accelerations_at(double t, const double* y, double* vdot) = 0;
  // The same with the rates of coordinates, before, and element states, after these.
  virtual void rates_at(double t, const double* y, double* ydot) = 0;
  // Called when a remembered mode has changed.
  virtual void mode_changed() = 0;
  // Brings the inputs of `dynamics` to t, and the element states to those in y; returns whether they change from there
  // on.
  virtual bool bring_inputs(double t, const double* y) = 0;
  // Whether an input or a prescribed motion changes with time.
  virtual bool loads_move() const = 0;
  // Of prescribed motions, see EventSource.
  virtual bool has_breaks() const = 0;
  virtual double next_break(double t) = 0;
  virtual void begin_stretch(double from, double to) = 0;

 protected:
  ~ModeEquations() = default;
};

// What a decision on modes records: a preview, nothing; one at an event, what is doubtful.
enum class Recording : char { nothing, doubts };

// Of a run.
struct ModeCounts {
  long impacts = 0;        // on bounds of joints, and of shapes
  long closed_series = 0;  // series of impacts that have ended in contact
  long ambiguous = 0;      // decisions with more than one consistent outcome, or none
};

}  // namespace gelenk
