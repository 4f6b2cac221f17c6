// SPDX-License-Identifier: BSD-3-Clause
// From a scene to islands that stand at consistent start values, with the reductions that only these reveal.
#pragma once

#include <string>
#include <vector>

#include "analysis/mobility.h"
#include "assembly/assembly.h"
#include "formulation/inputs.h"

namespace gelenk {

// The loops cannot be closed with these start values. Says the smallest gap and the joint where it gapes.
class AssemblyError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Likewise, of a loop that gapes by little: numbers with few digits may be the reason.
class OpenLoop : public AssemblyError {
 public:
  OpenLoop(const std::string& what, double gap) : AssemblyError(what), gap(gap) {}
  double gap;  // m or rad, in natural units
};

struct PreparedIsland {
  Mechanism mechanism;  // without the rows that are not needed
  Assembled start;
  std::vector<double> cut_start;  // wished coordinates of the cut joints, to count turns from
  MobilityAnalysis mobility;      // of the island with all its rows, as in ReducedScene::islands
};

struct PreparedScene {
  ReducedScene reduced;
  std::vector<PreparedIsland> islands;
  std::string report;                 // on assembly, for people
  std::vector<std::string> warnings;  // of what is doubtful about the start, likewise
  // Its numbers may have been rounded: equations of loops contradict each other, or what stands still hardly does.
  bool doubtful = false;
};

// The scene as kinematics alone: everything in it has inertia, rods without mass are bodies as others are.
ReducedScene reduce_to_geometry(const Scene& scene);

// reduced: reduce(scene). time [s], inputs: of the start, where rows change with them. Throws AssemblyError, and
// SceneError for parts that move without inertia. asking: where the outcome is doubtful, preparation ends there.
PreparedScene prepare(const Scene& scene, const ReducedScene& reduced, double time, const Inputs& inputs,
                      bool asking = false);

}  // namespace gelenk
