// SPDX-License-Identifier: BSD-3-Clause
// Equilibria and steady motions of a mechanism, under given inputs or with the inputs that hold them.
#pragma once

#include <vector>

#include "analysis/constrained_sensitivity.h"
#include "outputs/outputs.h"

namespace gelenk {

// A position is an equilibrium if its accelerations, in the mechanism's own length and time scales, do not exceed
// equilibrium_rate_tolerance plus the effect of rounding errors in the coordinates, equilibrium_rounding_tolerance
// times the sum of the absolute terms. Also used by gelenk.linearize, to warn of a point that is no equilibrium.
inline constexpr double equilibrium_rate_tolerance = 1e-8;
inline constexpr double equilibrium_rounding_tolerance = 1e-13;  // ten times the rounding error of closed loops

// What is asked for beyond an equilibrium at rest under given inputs. Outputs are those of joints, by index.
struct EquilibriumRequest {
  // A coordinate, or a velocity in steady motion, that has a given value. No force holds it there but those of the
  // mechanism, the inputs, and contact with a limit.
  struct Held {
    int output = 0;
    double value = 0;
    int joint = 0, component = 0;  // of the scene, and within it
    int order = 0;                 // 0: coordinate, 1: velocity
  };
  struct UnknownInput {
    int input = 0;
    double size = 1;  // 1 in the mechanism's own length, mass and time scales
  };
  std::vector<Held> held{};
  std::vector<UnknownInput> solve_for{};
  // Steady motion: velocities are unknowns, too, and these accelerations vanish instead of all. Friction of what moves
  // acts, and what rests sticks.
  bool steady = false;
  std::vector<int> accelerations{};
  bool only_approach = false;  // only moves to the values held
};

// The equilibrium problem of a mechanism; the referenced objects must outlive the search.
struct EquilibriumProblem {
  const Mechanism& mechanism;
  const Loads& loads;
  const MobilityAnalysis& mobility;
  const Outputs& outputs;
  const std::vector<double>& u;                        // inputs, clock and element states
  const std::vector<MotionLaw::Derivatives>& targets;  // of the coordinate rows, under these
  double time = 1;                                     // s: time scale of the mechanism, for the tolerances
  EquilibriumRequest request{};
};

struct Equilibrium {
  enum class End {
    found,
    not_converged,
    none_near,    // converged, but not to an equilibrium
    unreachable,  // the values held cannot be reached
  };
  End end = End::found;
  int steps = 0;
  std::vector<double> q, cut_q, v, u;  // of the tree joints; of the cut joints, full turns counted; all inputs
  // Residual: of all velocities; those requested in steady motion; rates of the element states.
  Eigen::VectorXd vdot, accelerations, rates;
};

// Finds an equilibrium without dry friction, or a steady motion, from the closed position q and velocities v by
// Newton's method on the independent coordinates, velocities in steady motion, unknown inputs and element states. First
// it moves to the values held; of several solutions, steps and inputs have minimum norm. Steps are limited so that
// loops stay on their branch, and shortened until the next one would be shorter (natural monotonicity test: Deuflhard
// 2004, ch. 3). If this fails at rest, for example at a maximum of the accelerations, pseudo-transient continuation
// descends to a stable pose, from which Newton's method continues; the second time it descends to the minimum.
// Directions without stiffness are left unchanged. The equilibrium may be unstable. Coordinates that meet a hard limit
// remain at it while it has to push (active-set method: Nocedal & Wright 2006, ch. 16); where inputs are unknown, these
// bear what is held, not its limit. Throws NotDifferentiablePoint or SingularMass if q has no derivatives and is no
// equilibrium.
Equilibrium find_equilibrium(const EquilibriumProblem& of, const std::vector<double>& q,
                             const std::vector<double>& cut_q, const std::vector<double>& v);

}  // namespace gelenk
