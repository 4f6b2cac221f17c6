// SPDX-License-Identifier: BSD-3-Clause
// P-SPG-FB: the spectral projected gradient (Birgin, Martinez & Raydan 2000) as used for cone complementarity by Heyn,
// Anitescu, Tasora & Negrut (2013). The preconditioner, one number per cone, is contained in the scaled variables; the
// fall-back to the best iterate, in ConeIteration. The line search is exact for a quadratic and G x is updated by the
// step, so that one product per iteration suffices.
#pragma once

#include "complementarity/iteration.h"

namespace gelenk {

class SpectralGradient {
 public:
  // Allocates what a problem of this size needs.
  void reserve(Eigen::Index unknowns) { memory_.start(4 * unknowns); }
  // Up to max_steps iterations. In an exact problem the shift s(u) is constant until the convex problem has been solved
  // to a fraction of the residual, then it is renewed.
  void run(ConeIteration& at, int max_steps);

 private:
  void direction(ConeIteration& at, double length);
  double step_fraction(double decrease, double curvature);
  void remember(double value);

  static constexpr int window = 10;  // values of the objective, of which a step may exceed all but the largest
  ConeMemory memory_;
  double *shift_ = nullptr, *gradient_ = nullptr, *d_ = nullptr, *Gd_ = nullptr;
  double values_[window] = {};  // of the objective, relative to that at the start
  int next_ = 0;
};

}  // namespace gelenk
