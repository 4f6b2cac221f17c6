// SPDX-License-Identifier: BSD-3-Clause
// The ways in which the parts of a scene can be put together, in the user's coordinates.
#pragma once

#include <string>
#include <vector>

#include "assembly/branches.h"

namespace gelenk {

// One way to put a part together.
struct Assembly {
  std::vector<std::vector<double>> q;  // by joint of the part: the user's coordinates
  double distance = 0;
  int degrees_of_freedom = 0, hits = 0;
  bool chosen = false;  // the scene's own start values lead here
  bool flat = false;
};

// What moves apart from the rest and has loops: any of its assemblies goes with any of another part's.
struct AssemblyPart {
  std::vector<int> joints;  // of the scene
  std::vector<Assembly> assemblies;
  int starts = 0, closed = 0;
  bool settled = false;
};

// As find_branches. bodies: assemblies in which these stand alike count as one, and parts without any of them are left
// out; none: all coordinates count. Throws AssemblyError where the scene's own start values lead to no assembly, and
// UsageError for a body that does not exist.
std::vector<AssemblyPart> list_assemblies(const Scene& scene, const std::vector<std::string>& bodies, int most_starts,
                                          unsigned seed);

}  // namespace gelenk
