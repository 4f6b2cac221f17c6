// SPDX-License-Identifier: BSD-3-Clause
// Which cones of a problem act on each other, directly or by others.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "complementarity/cone.h"
#include "util/disjoint_sets.h"

namespace gelenk {

// Keeps its memory: a problem no larger than those before allocates nothing.
class PartsOfProblem {
 public:
  // Returns whether there are several parts; an operator without a matrix or a root is taken for one.
  bool divide(const ConeProblem& problem);
  // Of the last problem that was divided: number of the part and cone, in the order of the first cones of parts.
  std::span<const std::pair<int, int>> by_part() const { return by_part_; }

 private:
  void join_by_matrix(const ConeProblem& problem);
  void join_by_root(const ConeProblem& problem);

  DisjointSets sets_{0};                      // of cones
  std::vector<int> number_;                   // of a part, by representative
  std::vector<std::pair<int, int>> by_part_;  // number of the part, cone
  std::vector<int> cone_of_row_;              // of the root: one that reaches it
};

// Calls visit(pairs) for each part of by_part().
template <class Visit>
void each_part_of(std::span<const std::pair<int, int>> by_part, Visit visit) {
  for (std::size_t first = 0; first < by_part.size();) {
    std::size_t end = first;
    while (end < by_part.size() && by_part[end].first == by_part[first].first) ++end;
    visit(by_part.subspan(first, end - first));
    first = end;
  }
}

}  // namespace gelenk
