// SPDX-License-Identifier: BSD-3-Clause
// Targets of the coordinate rows of a mechanism as functions of time.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "formulation/inputs.h"
#include "mechanism/mechanism.h"

namespace gelenk {

class Targets {
 public:
  explicit Targets(const Mechanism& mechanism) : rows_(mechanism.coordinate_rows), now_(3 * rows_.size()) {}

  bool none() const { return rows_.empty(); }
  // See EventSource.
  bool has_breaks() const;
  double next_break(double t) const;
  void begin_stretch(double from, double to) { stretch_ = {from, to}; }
  // s, s', s'' of each row at t [s] (Dynamics::set_targets); overwritten by the next call.
  const double* at(double t, const Inputs& inputs);
  // The same at the present time t of the run, as read by outputs (Inputs::rate).
  const double* as_read(double t, const Inputs& inputs);
  // s and its first four derivatives as read by outputs; unknown derivatives of inputs are 0.
  MotionLaw::Derivatives derivatives(int row, double t, const Inputs& inputs) const;

 private:
  template <class Of>
  const double* fill(Of derivatives_of);
  double inside_stretch(double t) const;

  const std::vector<CoordinateRow>& rows_;
  std::array<double, 2> stretch_{NAN, NAN};  // s: from one break to the next, see EventSource
  std::vector<double> now_;
};

}  // namespace gelenk
