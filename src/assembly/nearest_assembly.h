// SPDX-License-Identifier: BSD-3-Clause
// The closed position of a group of loops that is nearest to the guesses.
#pragma once

#include <vector>

#include "assembly/loop_groups.h"

namespace gelenk {

struct NearestAssembly {
  bool closed = false;          // false: q is the position with the smallest closure error
  std::vector<double> equal_q;  // another assembly that is as near; empty: none is known
  int tries = 1;                // number of starts until the loops closed
};

// Closes the loops of the group from q, in which only its coordinates change. Start values that already close them are
// kept: then only coordinates that the user did not give are solved for.
NearestAssembly close_nearest(const Mechanism& mechanism, Dynamics& dynamics, const LoopGroup& group,
                              const InitialGuess& tree, const InitialGuess& cuts, std::vector<double>& q);

}  // namespace gelenk
