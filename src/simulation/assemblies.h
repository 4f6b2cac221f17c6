// SPDX-License-Identifier: BSD-3-Clause
// The assemblies of a scene, that is, the positions in which its loops close, in the user's coordinates.
#pragma once

#include <string>
#include <vector>

#include "assembly/branches.h"
#include "scene/scene.h"

namespace gelenk {

// An assembly of one island.
struct Assembly {
  std::vector<std::vector<double>> q;  // by joint of the island: the user's coordinates, in SI units
  double distance = 0;                 // see Branch (assembly/branches.h), also for the following members
  int degrees_of_freedom = 0, hits = 0;
  bool chosen = false;  // the scene's own start values lead here
  bool flat = false;
};

// An island with loops. Assemblies of different islands can be combined freely.
struct AssemblyPart {
  std::vector<int> joints;  // indices in the scene
  std::vector<Assembly> assemblies;
  int starts = 0, closed = 0;
  bool settled = false;
};

// Lists the assemblies of all islands with loops (see find_branches). bodies: assemblies with equal poses of these
// bodies count as one, and islands without any of them are omitted; if empty, all coordinates are compared. Throws
// AssemblyError if the scene's own start values lead to no assembly, and UsageError for an unknown body.
std::vector<AssemblyPart> list_assemblies(const Scene& scene, const std::vector<std::string>& bodies, int most_starts,
                                          unsigned seed);

}  // namespace gelenk
