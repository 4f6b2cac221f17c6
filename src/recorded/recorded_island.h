// SPDX-License-Identifier: BSD-3-Clause
// One island, recorded: the equations of its mechanism, in the mechanism's signs.
#pragma once

#include <string>
#include <vector>

#include "kinematics/loads.h"
#include "mechanism/mechanism.h"
#include "recording/recorded.h"

namespace gelenk {

struct RecordedIsland {
  using Numbers = std::vector<recording::Recorded>;
  Numbers q, v, signals, targets;  // given; signals: those of kinematics/loads.h that are not named
  Numbers sides;  // given, or none: the held modes of the forces along tree joints that have any; 1, 0 or -1
  Numbers M, J, h, gamma, Phi, rate, qdot, rates;  // M, J: row by row
  recording::Recorded kinetic, potential;
  Numbers distances;  // from poses at which constraint equations are undefined: below 1 near one
};

// Fills in what is not given. Without sides, friction along joints slides in the direction of the speed, and all other
// forces with modes are in mode 0. cut_reference: coordinates of cut joints, with their turns. Throws
// recording::HiddenBranch.
void record(const Mechanism& mechanism, const Loads& loads, const std::vector<double>& cut_reference,
            RecordedIsland& island);

// The forces between bodies, by their index in the scene, of which the laws have hidden branches. island: as given to
// record(), and with the named signals.
std::vector<int> forces_with_hidden_branches(const Mechanism& mechanism, const Loads& loads,
                                             const RecordedIsland& island);

// Elements along tree joints, cuts with their joints and elements, relations, and element states of the island that
// have hidden branches.
struct HiddenAtJoints {
  struct Along {
    int joint = 0, component = 0;  // of the scene
  };
  std::vector<Along> elements;
  std::vector<int> cuts, coordinate_rows, states;
};
HiddenAtJoints joints_with_hidden_branches(const Mechanism& mechanism, const Loads& loads,
                                           const std::vector<double>& cut_reference, const RecordedIsland& island);

// The forces with modes, each once, that are friction by what bearings, guides or meshes transmit.
std::vector<int> friction_by_loads(const Mechanism& mechanism, const Loads& loads);

}  // namespace gelenk
