// SPDX-License-Identifier: BSD-3-Clause
// The searches of assembly: to a place where the loops are closed, and along the closed loops towards the wishes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "assembly/assembly_problem.h"

namespace gelenk {

inline constexpr double assembled_gap = 1e-9;       // m or rad: what the user is promised
inline constexpr double closure_tolerance = 1e-13;  // of the mechanism's length: some hundreds of roundings

// Closes the loops from q by Levenberg-Marquardt steps, fixed values kept; returns the largest gap left.
double close_loops(AssemblyProblem& problem, std::vector<double>& q);
// Closes all rows from q, whatever is wished; false where that fails. Asks for no rank: off the loops rows that repeat
// others look independent, and at a singular start rows that are independent do not. Leaves `dynamics` anywhere.
bool close_rows(const Mechanism& mechanism, Dynamics& dynamics, std::vector<double>& q);

// From q to where gaps and weighted distances together are small: wishes of cut joints pull the tree before it closes.
void relax(AssemblyProblem& problem, std::vector<double>& q);

// Moves along the closed loops to where the weighted distance is least (each trial is closed again, and judged by the
// distance, so this is no descend()): Gauss-Newton, then Newton with the curvature of the loops, which settles the last
// digits however far away the wishes are. (Nocedal & Wright, ch. 10 and 18.)
void minimize_distance(AssemblyProblem& problem, std::vector<double>& q);

// What remains free at q where the loops are closed, and how the weighted distance behaves along it.
struct LocalMinimum {
  Eigen::Index degrees_of_freedom = 0;
  double gradient = 0;         // largest component of the gradient of half the squared distance, along the freedoms
  double least_curvature = 0;  // least eigenvalue of its second derivatives along the closed loops; 0 without freedoms
};
LocalMinimum local_minimum_at(AssemblyProblem& problem, const std::vector<double>& q);

// The speeds that the loops (s.G v = -s.g0, pivots below `threshold` of the largest taken for zero) allow nearest to
// the wishes.
Eigen::VectorXd nearest_speeds(const AssemblyProblem::Speeds& s, double threshold);

// The wishes, their free coordinates perturbed the more the higher the attempt, always the same way; 0: as they are.
std::vector<double> perturbed(const AssemblyProblem& problem, const std::vector<double>& q, int attempt);
inline constexpr int most_attempts = 24;  // after these the free coordinates have been anywhere

}  // namespace gelenk
