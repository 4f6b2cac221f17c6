// SPDX-License-Identifier: BSD-3-Clause
// The cone complementarity problem of a single cone, for methods that solve one after the other.
#pragma once

#include "complementarity/cone.h"

namespace gelenk {

// x <- the solution of K contains x, W x + q + s in K*, x . (W x + q + s) = 0, with s = s(W x + q) if exact, else 0. x
// is the initial guess on entry. W: cone.size() squared numbers with a mean diagonal of about 1. Semismooth Newton
// steps on the natural map, and projected gradient steps where they fail; the number of steps is bounded.
void solve_block(const Cone& cone, const double* W, const double* q, bool exact, double* x);

}  // namespace gelenk
