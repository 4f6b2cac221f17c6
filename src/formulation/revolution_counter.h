// SPDX-License-Identifier: BSD-3-Clause
// Counts the full turns of cut joints, whose angles follow from the state only modulo one turn.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "util/archive.h"

namespace gelenk {

class RevolutionCounter {
 public:
  RevolutionCounter(const Mechanism& mechanism, Dynamics& dynamics);

  // Coordinates of the cut joints with unwrapped angles; cut_nq numbers.
  const std::vector<double>& coordinates() const { return q_; }
  // Their velocities at the last count; cut_nv numbers.
  const std::vector<double>& speeds() const { return v_last_; }
  // Starts counting at (t, y), y = (q, v), with the angles nearest to cut_q.
  void count_from(const std::vector<double>& cut_q, double t, const double* y);
  // Saves or restores the counts.
  void serialize(Archive& archive);
  // Updates the counts after a step to (t, y); the velocities at both ends of the step identify the turn.
  void count(double t, const double* y);
  // Keeps the last count, and returns to the one kept last: trial states are counted from there.
  void keep();
  void return_to_kept();
  void serialize_kept(Archive& archive) { archive.serialize(kept_.q, kept_.v, kept_.time); }

 private:
  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> q_, v_, v_last_;
  double last_time_ = 0;
  struct Count {
    std::vector<double> q, v;
    double time = 0;
  };
  Count kept_;
};

}  // namespace gelenk
