// SPDX-License-Identifier: BSD-3-Clause
// Report on what the reductions did to a scene.
#pragma once

#include <string>
#include <vector>

#include "preparation/adjustment.h"
#include "simulation/simulation.h"

namespace gelenk {

// A loop-closure equation that is redundant at every position.
struct RedundantRow {
  std::string joint;   // the loop-closing joint
  std::string motion;  // the motion it prevents, in the joint's frame: "sliding along z", "turning about (0.6, 0.8, 0)"
};

struct ReductionReport {
  std::string name;  // as in solver.reductions
  bool on = true;
  bool changed = false;            // whether it made the model smaller
  std::vector<std::string> notes;  // one sentence each; empty: not applicable
};

struct Inspection {
  ModelSize described;                              // the whole scene without reductions; rank not known
  ModelSize reduced;                                // the model that is computed
  std::vector<ReductionReport> reductions;          // in the order of enum Reduction
  std::vector<RedundantRow> redundant_rows;         // omitted, or absent in planar algebra
  std::vector<std::string> undetermined_reactions;  // "A.f[3]": statically indeterminate components
  int counted_degrees_of_freedom = 0;               // Gruebler's count: 6 per body, minus all constraints
  int initial_degrees_of_freedom = 0;               // at the start: more if it is singular
  std::vector<MovedFrame> moved_frames;             // so that loops with rounded dimensions close [m]
  std::vector<std::string> mobility;                // why the degrees of freedom differ from the count; clauses
  std::string left_out;                             // clause on what no wanted output depends on; may be empty
};

// Inspects an initialized simulation; a planar mechanism is also analyzed in space. whole: the original scene, possibly
// with parts that no wanted output depends on and that the simulation does not have.
Inspection inspect(Simulation& simulation, const Scene& whole);

}  // namespace gelenk
