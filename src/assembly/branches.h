// SPDX-License-Identifier: BSD-3-Clause
// All assemblies of a mechanism.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

struct Branch {
  std::vector<double> q;       // of the tree joints
  std::vector<Pose3> poses{};  // of the links listed in Search, in the root frame
  double distance = 0;  // square root of the weighted squared distance from the guesses, including unspecified ones
  int degrees_of_freedom = 0;    // left by the fixed values
  int hits = 0;                  // number of searches that ended here
  bool is_default = false;       // the assembly found by assemble()
  bool is_not_isolated = false;  // one of a connected set at the same distance from the guesses
};

struct Search {
  int max_starts = 0;
  unsigned seed = 1;
  // Assemblies in which these links have the same poses count as one, of which the nearest is listed; empty: all
  // coordinates are compared.
  std::vector<int> links{};
};

struct Branches {
  std::vector<Branch> found;   // sorted by distance
  int starts = 0, closed = 0;  // searches, and those of them that closed the loops
  bool settled = false;        // the search ended because no new assemblies were found
};

// Finds the positions in which the loops are closed and the fixed values kept; if degrees of freedom remain, the local
// minima of the distance from the guesses. Searches from random starts, reproducibly, until another assembly is
// unlikely to be found or max_starts are made: an assembly that few starts lead to can be missed.
// Throws CannotAssemble as assemble() does.
Branches find_branches(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                       const InitialGuess& cuts, const Search& search);

}  // namespace gelenk
