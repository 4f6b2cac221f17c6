// SPDX-License-Identifier: BSD-3-Clause
// Counts the turns of cut joints, whose angles the state knows within a turn only.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "util/archive.h"

namespace gelenk {

class RevolutionCounter {
 public:
  RevolutionCounter(const Mechanism& mechanism, Dynamics& dynamics);

  // Coordinates of the cut joints with their angles counted through all turns; cut_nq numbers.
  const std::vector<double>& coordinates() const { return q_; }
  // Their speeds, where they were counted last; cut_nv numbers.
  const std::vector<double>& speeds() const { return v_last_; }
  // Starts counting: angles nearest to the numbers given. y = (q, v).
  void count_from(const std::vector<double>& cut_q, double t, const double* y);
  // The counts, for the state at which the run stands.
  void serialize(Archive& archive);
  // The speeds at both ends of the step say which turn it is.
  void count(double t, const double* y);

 private:
  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> q_, v_, v_last_;
  double last_time_ = 0;
};

}  // namespace gelenk
