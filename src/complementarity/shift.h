// SPDX-License-Identifier: BSD-3-Clause
// De Saxce's shift s(u) held constant, so that methods for the convex problem solve the exact one by a fixed-point
// iteration (Cadoux 2009; Acary & Cadoux 2013).
#pragma once

#include "complementarity/iteration.h"

namespace gelenk {

class FrozenShift {
 public:
  // shift, work: at.size() numbers each. Sets the shift to s(u) of the present iterate; to 0 in a convex problem.
  FrozenShift(ConeIteration& at, double* shift, double* work) : at_(at), shift_(shift), work_(work) { renew(); }

  // Call after each iteration. Renews the shift once the residual of the convex problem is a fraction of that of the
  // exact one; returns whether it did.
  bool renew_if_solved();

 private:
  void renew();
  double convex_residual();

  ConeIteration& at_;
  double* shift_;
  double* work_;
};

}  // namespace gelenk
