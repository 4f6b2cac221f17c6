// SPDX-License-Identifier: BSD-3-Clause
// The iterations of assembly: closing the loops, and minimizing the distance from the guesses along the closed loops.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "assembly/assembly_problem.h"

namespace gelenk {

inline constexpr double assembled_gap = 1e-9;       // m or rad: closure error guaranteed to the user
inline constexpr double closure_tolerance = 1e-13;  // relative to the mechanism's length: some hundred roundings

// Where closing gives up.
struct ClosingLimits {
  int steps = 200;
  AssemblyProblem::Squared within = {INFINITY, INFINITY};  // distances of the tree's coordinates from their guesses
};

// Closes the loops from q by Levenberg-Marquardt steps with fixed values kept; returns the largest closure error left
// [m, rad].
double close_loops(AssemblyProblem& problem, std::vector<double>& q, const ClosingLimits& limits = {});
// Satisfies all constraint equations from q, without regard to guesses; returns false if that fails. It does not use
// the rank: away from closed loops redundant constraints look independent, and at a singular start independent ones do
// not. Leaves `dynamics` at an arbitrary position.
bool close_rows(const Mechanism& mechanism, Dynamics& dynamics, std::vector<double>& q);

// Minimizes the squares of closure errors and weighted distances together, so that guesses guide the tree before it
// closes; returns their sum. Low accuracy suffices.
double relax(AssemblyProblem& problem, std::vector<double>& q);

// Moves along the closed loops to a minimum of the weighted distance. Each trial is closed again and judged by the
// distance, so this is no descend(). Gauss-Newton, then Newton with the curvature of the loops, which converges in the
// last digits however far away the guesses are (Nocedal & Wright, ch. 10 and 18).
void minimize_distance(AssemblyProblem& problem, std::vector<double>& q);

// The degrees of freedom at q where the loops are closed, and derivatives of the weighted distance along them.
struct LocalMinimum {
  Eigen::Index degrees_of_freedom = 0;
  double gradient = 0;         // largest component of the gradient of half the squared distance along the closed loops
  double least_curvature = 0;  // smallest eigenvalue of its Hessian along the closed loops; 0 if nothing is free
};
LocalMinimum local_minimum_at(AssemblyProblem& problem, const std::vector<double>& q);

// The velocities nearest to the guesses that satisfy s.G v = -s.g0: those that were given change least and, as far as
// these leave a choice, the others. Pivots below `threshold` times the largest
// count as zero.
Eigen::VectorXd nearest_velocities(const AssemblyProblem::VelocityEquations& s, double threshold);

}  // namespace gelenk
