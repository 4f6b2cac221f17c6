// SPDX-License-Identifier: BSD-3-Clause
// Prepares the islands of a scene at consistent start values, with the reductions that depend on these.
#pragma once

#include <string>
#include <vector>

#include "analysis/mobility.h"
#include "assembly/assembly.h"
#include "formulation/inputs.h"
#include "mechanism/mechanism.h"
#include "preparation/assembly_error.h"
#include "scene/scene.h"

namespace gelenk {

struct PreparedIsland {
  Mechanism mechanism;  // without redundant rows
  Assembled start;
  std::vector<double> cut_start;  // guessed coordinates of the cut joints, from which turns are counted
  // Whether its constraints alone determine its positions at any time, without contacts, element states or rolling.
  bool is_positioned() const {
    return mechanism.nv > 0 && mobility.position_rank == mechanism.nv && mechanism.states.empty() &&
           !mechanism.touches();
  }
  MobilityAnalysis mobility;   // of the island with all rows, as in ReducedScene::islands
  std::vector<double> states;  // start values of its element states
};

struct PreparedScene {
  ReducedScene reduced;
  std::vector<PreparedIsland> islands;
  std::string report;                 // readable description of the assembly
  std::vector<std::string> warnings;  // readable warnings about the start
  // The dimensions may have been rounded: constraint equations are inconsistent, or immobile parts are barely so.
  bool doubtful = false;
};

// Whether constraint equations of the island are inconsistent at its start, or immobile parts barely so.
bool is_doubtful(const PreparedIsland& island);

// Reduces a scene for purely kinematic computations: all links have unit inertias, and massless rods remain bodies.
ReducedScene reduce_to_geometry(const Scene& scene);

// Assembles the islands of a scene and analyzes their mobility. reduced: reduce(scene). time [s], inputs: at the start,
// for constraint equations that depend on them. stop_if_doubtful: return early if PreparedScene::doubtful is set.
// Throws AssemblyError, and SceneError for parts that move without inertia.
PreparedScene prepare(const Scene& scene, const ReducedScene& reduced, double time, const Inputs& inputs,
                      bool stop_if_doubtful = false);

}  // namespace gelenk
