// SPDX-License-Identifier: BSD-3-Clause
// What the coordinate rows of a mechanism are to be at a time.
#pragma once

#include <array>
#include <vector>

#include "formulation/inputs.h"
#include "mechanism/mechanism.h"

namespace gelenk {

class Targets {
 public:
  explicit Targets(const Mechanism& mechanism) : rows_(mechanism.coordinate_rows), now_(3 * rows_.size()) {}

  bool none() const { return rows_.empty(); }
  // s, s', s'' of each row at t [s] (Dynamics::set_targets); overwritten by the next call.
  const double* at(double t, const Inputs& inputs);
  // Likewise at the time t at which the run stands, as outputs are read there (Inputs::rate).
  const double* as_read(double t, const Inputs& inputs);
  // s and its first four derivatives, as read; of inputs those that are known.
  MotionLaw::Derivatives derivatives(int row, double t, const Inputs& inputs) const;

 private:
  template <class Of>
  const double* fill(Of derivatives_of);

  const std::vector<CoordinateRow>& rows_;
  std::vector<double> now_;
};

}  // namespace gelenk
