// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// Reductions of the model that leave its results unchanged (mechanism/). Each can be switched off for comparison.
enum class Reduction {
  weld,            // bodies welded together become one link
  fixed,           // "static": bodies that cannot move become part of the ground
  cut_choice,      // loops are cut at joints that give the fewest constraint equations and quaternions
  planar,          // planar mechanisms are solved in their plane
  redundant_rows,  // constraint equations implied by the others at every position are removed
  islands,         // parts that are not coupled are integrated separately
  outputs,         // only the stages that the requested outputs depend on are computed
  massless,        // massless rods become distance constraints
  kinematic,       // mechanisms without degrees of freedom are not integrated
};
inline constexpr int reduction_count = 9;

}  // namespace gelenk
