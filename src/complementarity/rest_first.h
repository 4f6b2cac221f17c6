// SPDX-License-Identifier: BSD-3-Clause
// What can remain at rest does: where normal forces are redundant, Coulomb's law may permit motion as well as rest. The
// convex problem, in which friction lifts what slides, has the least velocities, none if any impulses hold everything.
#pragma once

#include <vector>

#include "complementarity/cone.h"

namespace gelenk {

class RestFirst {
 public:
  // Whether no contact that pushes moves along components that friction limits, with the velocities u: a solution x of
  // the convex problem is then one of the exact problem, too.
  static bool all_stick(std::span<const Cone> cones, const double* x, const double* u, double tolerance);

  // Solves the exact problem, with such a solution if there is one. rest: velocities up to which something is at rest.
  // Their iterations add up to max_iterations at most. Allocates nothing if the problem is no larger than those before.
  ConeResult solve(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options, double rest, double* x);

 private:
  std::vector<double> held_, u_;
};

}  // namespace gelenk
