// SPDX-License-Identifier: BSD-3-Clause
// The different ways in which a mechanism can be put together.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

struct Branch {
  std::vector<double> q;       // of the tree
  std::vector<Pose3> poses{};  // of the links of Search, in the root frame
  double distance = 0;         // root of the weighted squared distance from the wishes, those not given included
  int degrees_of_freedom = 0;  // that the fixed values leave
  int hits = 0;                // searches that ended here
  bool chosen = false;         // where assemble() leads
  bool flat = false;           // one of many, connected, at the same distance: the wishes do not tell them apart
};

struct Search {
  int most_starts = 0;
  unsigned seed = 1;
  // Branches in which these stand alike count as one, of which the nearest is listed; none: all coordinates count.
  std::vector<int> links{};
};

struct Branches {
  std::vector<Branch> found;   // the nearest first
  int starts = 0, closed = 0;  // searches, and those that closed the loops
  bool settled = false;        // the searches were stopped because they found nothing new any more
};

// Positions in which the loops are closed and the fixed values kept; where these leave freedoms, those of them whose
// distance from the wishes is least among their neighbours. Searched from many starts, the same ones each time, until
// it is unlikely that another will be found, or most_starts are made: a branch that few starts lead to can be missed.
// Throws CannotAssemble as assemble() does.
Branches find_branches(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                       const InitialGuess& cuts, const Search& search);

}  // namespace gelenk
