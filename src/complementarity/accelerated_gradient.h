// SPDX-License-Identifier: BSD-3-Clause
// APGD: Nesterov's accelerated projected gradient with backtracking of the step length (Mazhar, Heyn, Negrut & Tasora
// 2015) and restarts where the direction ascends (O'Donoghue & Candes 2015).
#pragma once

#include "complementarity/iteration.h"

namespace gelenk {

class AcceleratedGradient {
 public:
  // Allocates what a problem of this size needs.
  void reserve(Eigen::Index unknowns) { memory_.start(7 * unknowns); }
  // Up to max_steps iterations. For exact problems see FrozenShift.
  void run(ConeIteration& at, int max_steps);

 private:
  ConeMemory memory_;
};

}  // namespace gelenk
