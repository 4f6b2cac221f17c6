// SPDX-License-Identifier: BSD-3-Clause
// What programs compute of the equations of motion, as terms: accelerations, and what closes constraint equations.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "expression/graph.h"
#include "recorded/pivots.h"
#include "recording/recorded.h"

namespace gelenk {

using Terms = std::vector<expression::Term>;

Terms terms(const std::vector<recording::Recorded>& of);

// M vdot + h + J^T lambda = 0, J vdot = gamma. M: nv x nv, J: rows x nv, row by row.
struct EquationTerms {
  std::size_t nv = 0;
  const Terms &M, &J, &gamma, &h;
};

struct MotionTerms {
  // Records in the present Recording, of which the graph is that of the equations.
  MotionTerms(const expression::Graph& graph, const EquationTerms& of, const Pivots& pivots);

  Terms accelerations;
  // The smallest displacement in the mass metric that removes residuals, which are variables, by row of the pivots.
  Terms residual, displacement;
  // The reciprocals of the pivots of J, and of those of the reduced mass matrix, which belong to independent
  // velocities.
  Terms reciprocal_pivots, reciprocal_masses;
  std::vector<int> free;
  // What displacement needs besides residuals, and the reciprocals; no constants.
  Terms factors;
};

// Those of a term by row that belong to pivots.
Terms of_pivots(const Terms& by_row, const Pivots& pivots);

// Adds terms that are neither constant nor among `to`.
void add_varying(const expression::Graph& graph, const Terms& of, Terms& to);

// Whether this is the index of a variable of MotionTerms::residual.
bool is_residual(int variable);

// The largest parts of terms that depend on none of the variables for which `depends` holds, and are no constants.
Terms independent_parts(const expression::Graph& graph, const Terms& of, const std::function<bool(int)>& depends);

}  // namespace gelenk
