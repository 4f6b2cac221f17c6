// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/parts_of_problem.h"

#include <algorithm>
#include <cstddef>

namespace gelenk {

void PartsOfProblem::join_by_matrix(const ConeProblem& problem) {
  const auto n = static_cast<std::size_t>(problem.G.size());
  const double* const G = problem.G.dense();
  const auto act = [&](const Cone& a, const Cone& b) {
    for (int j = a.first; j < a.first + a.size(); ++j) {
      const double* const column = G + n * static_cast<std::size_t>(j);
      if (std::any_of(column + b.first, column + b.first + b.size(), [](double g) { return g != 0; })) return true;
    }
    return false;
  };
  for (std::size_t a = 0; a < problem.cones.size(); ++a) {
    for (std::size_t b = a + 1; b < problem.cones.size(); ++b) {
      const int i = static_cast<int>(a);
      const int k = static_cast<int>(b);
      if (sets_.find(i) != sets_.find(k) && act(problem.cones[a], problem.cones[b])) sets_.join(i, k);
    }
  }
}

// Columns of the root that have entries in a common row.
void PartsOfProblem::join_by_root(const ConeProblem& problem) {
  const ConeRoot root = problem.G.root();
  cone_of_row_.assign(static_cast<std::size_t>(root.rows), -1);
  for (std::size_t c = 0; c < problem.cones.size(); ++c) {
    const Cone& cone = problem.cones[c];
    for (int unknown = cone.first; unknown < cone.first + cone.size(); ++unknown) {
      for (const int row : root.column(unknown).row) {
        int& other = cone_of_row_[static_cast<std::size_t>(row)];
        if (other >= 0) sets_.join(other, static_cast<int>(c));
        other = static_cast<int>(c);
      }
    }
  }
}

// Lists the cones of each part, in the order of their first ones.
bool PartsOfProblem::divide(const ConeProblem& problem) {
  sets_.reset(problem.cones.size());
  by_part_.clear();
  if (problem.G.dense() != nullptr) {
    join_by_matrix(problem);
  } else if (!problem.G.root().first.empty()) {
    join_by_root(problem);
  } else {
    for (std::size_t c = 1; c < problem.cones.size(); ++c) sets_.join(0, static_cast<int>(c));
  }
  int parts = 0;
  number_.assign(problem.cones.size(), -1);
  for (int c = 0; c < static_cast<int>(problem.cones.size()); ++c) {
    int& number = number_[static_cast<std::size_t>(sets_.find(c))];
    if (number < 0) number = parts++;
    by_part_.emplace_back(number, c);
  }
  std::ranges::sort(by_part_);
  return parts > 1;
}

}  // namespace gelenk
