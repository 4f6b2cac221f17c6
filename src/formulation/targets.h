// SPDX-License-Identifier: BSD-3-Clause
// Targets of the coordinate rows of a mechanism as functions of time.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "formulation/inputs.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {

class Targets {
 public:
  // Both must outlive it.
  Targets(const Mechanism& mechanism, const Loads& loads)
      : rows_(mechanism.coordinate_rows), loads_(loads), now_(3 * rows_.size()) {}

  bool none() const { return rows_.empty(); }
  // See EventSource.
  bool has_breaks() const;
  double next_break(double t) const;
  void begin_stretch(double from, double to) { stretch_ = {from, to}; }
  // s, s', s'' of each row at t [s] (Dynamics::set_targets); overwritten by the next call. u: the signals there
  // (kinematics/loads.h).
  const double* at(double t, const Inputs& inputs, const double* u);
  // The same at the present time t of the run, as read by outputs (Inputs::rate).
  const double* as_read(double t, const Inputs& inputs, const double* u);
  // s and its first four derivatives as read by outputs; unknown derivatives of inputs are 0, and those beyond the
  // second of what follows signals.
  MotionLaw::Derivatives derivatives(int row, double t, const Inputs& inputs, const double* u) const;

 private:
  template <class Of>
  const double* fill(Of derivatives_of);
  double inside_stretch(double t) const;

  MotionLaw::Derivatives of_signals(int row, const double* u) const;

  const std::vector<CoordinateRow>& rows_;
  const Loads& loads_;
  std::array<double, 2> stretch_{NAN, NAN};  // s: from one break to the next, see EventSource
  std::vector<double> now_;
};

}  // namespace gelenk
