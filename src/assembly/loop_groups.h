// SPDX-License-Identifier: BSD-3-Clause
// Groups of loops that share no joint and are coupled by no constraint: each closes independently of the others. Which
// joints belong together does not depend on where the loops are cut.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

struct Cut;

struct LoopGroup {
  std::vector<bool> velocities, cut_velocities, rows;  // those that belong to it
  int size = 0;                                        // number of its velocities, those of cut joints included
};

// The tree velocities that move a cut: those of the joints along its path_a, then along its path_b.
std::vector<int> velocities_between(const Mechanism& mechanism, const Cut& cut);

// Joints in no loop, whose coordinates nothing constrains, are in none.
std::vector<LoopGroup> loop_groups(const Mechanism& mechanism);

// The guesses of a group: its own, with weights relative to the largest, so that errors are too. The others have no
// weight. hold_others: and are fixed.
InitialGuess guesses_of(const InitialGuess& all, const std::vector<bool>& own, double largest_weight, bool hold_others);
// The largest weight of the group.
double largest_weight(const LoopGroup& group, const InitialGuess& tree, const InitialGuess& cuts);

}  // namespace gelenk
