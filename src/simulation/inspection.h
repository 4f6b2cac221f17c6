// SPDX-License-Identifier: BSD-3-Clause
// What the reductions did to a scene, for people and programs.
#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// A row of a loop that repeats others at every position.
struct RedundantRow {
  std::string joint;   // the one that is cut
  std::string motion;  // what it forbids, in the joint's frame: "sliding along z", "turning about (0.6, 0.8, 0)"
};

struct ReductionReport {
  std::string name;  // as in solver.reductions
  bool on = true;
  bool changed = false;            // it made the model smaller
  std::vector<std::string> notes;  // one sentence each; empty: it found nothing to do
};

struct Inspection {
  ModelSize described;                              // the whole scene taken literally: no reduction, rank not known
  ModelSize reduced;                                // what is computed
  std::vector<ReductionReport> reductions;          // in the order of enum Reduction
  std::vector<RedundantRow> redundant_rows;         // left out, or not there in the plane
  std::vector<std::string> undetermined_reactions;  // "A.f[3]": what rigid bodies leave open
  int counted_degrees_of_freedom = 0;               // by Gruebler's count: 6 for each body, less what joints forbid
  int initial_degrees_of_freedom = 0;               // at the start: more where it is singular
  std::vector<MovedFrame> moved_frames;             // so that loops with rounded numbers close; m
  std::vector<std::string> mobility;                // why the freedoms are not as counted; sentences
  std::string left_out;                             // what no wanted output depends on; a sentence, empty: nothing
};

// simulation: initialised. Looks at the scene in space, too, where it is computed in a plane.
// whole: the scene that it was made of, which may have more than any wanted output depends on.
Inspection inspect(Simulation& simulation, const Scene& whole);

}  // namespace gelenk
