// SPDX-License-Identifier: BSD-3-Clause
// Equilibria of a mechanism under given inputs.
#pragma once

#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/constrained_sensitivity.h"

namespace gelenk {

// A position is an equilibrium if its accelerations, in the mechanism's own length and time scales, do not exceed
// equilibrium_rate_tolerance plus the effect of rounding errors in the coordinates, equilibrium_rounding_tolerance
// times the sum of the absolute terms. Used by the searches here and in Python, and by gelenk.linearize to warn of a
// point that is no equilibrium.
inline constexpr double equilibrium_rate_tolerance = 1e-8;
inline constexpr double equilibrium_rounding_tolerance = 1e-13;  // ten times the rounding error of closed loops

// Thrown if no equilibrium was found.
class NoEquilibrium : public std::runtime_error {
 public:
  explicit NoEquilibrium(Eigen::VectorXd left) : std::runtime_error("no equilibrium"), left(std::move(left)) {}
  Eigen::VectorXd left;  // smallest residual accelerations reached, one per velocity
};

// The equilibrium problem of a mechanism; the referenced objects must outlive the search.
struct EquilibriumProblem {
  const Mechanism& mechanism;
  const Loads& loads;
  const MobilityAnalysis& mobility;
  const std::vector<double>& u;                        // all inputs
  const std::vector<MotionLaw::Derivatives>& targets;  // of the coordinate rows
  double time = 1;                                     // s: time scale of the mechanism, for the tolerances
};

struct Equilibrium {
  std::vector<double> q, cut_q;  // of the tree joints; of the cut joints, full turns counted
};

// Finds an equilibrium without dry friction, from the closed position q by Newton's method on the independent
// coordinates. Steps are limited
// so that loops stay on their branch, and shortened until the next one would be shorter (natural monotonicity test:
// Deuflhard 2004, ch. 3). If this fails, for example at a maximum of the accelerations, pseudo-transient continuation
// descends to a stable pose, from which Newton's method continues; the second time it descends to the minimum.
// Directions without stiffness are left unchanged. The equilibrium may be unstable. Coordinates that meet a hard limit
// remain at it while it has to push (active-set method: Nocedal & Wright 2006, ch. 16). gelenk.equilibrium begins with
// this search; its further features (fixed coordinates, inputs, steady motion, any FMU) use the same method in Python
// with the derivatives that a plant provides (python/gelenk/equilibria/newton.py). Throws NoEquilibrium, and
// NotDifferentiablePoint or SingularMass if q has no derivatives and is no equilibrium.
Equilibrium find_equilibrium(const EquilibriumProblem& of, const std::vector<double>& q,
                             const std::vector<double>& cut_q);

}  // namespace gelenk
