// SPDX-License-Identifier: BSD-3-Clause
// Positions from which assemblies are searched for; reproducible.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "assembly/assembly_problem.h"

namespace gelenk {

// q with its free coordinates perturbed, the more the higher the attempt; attempt 0 returns q.
std::vector<double> perturbed(const AssemblyProblem& problem, const std::vector<double>& q, int attempt);
inline constexpr int max_attempts = 24;  // by then the free coordinates have covered their whole range

// The guesses with random changes of the free coordinates: rotations over all orientations, lengths within the span of
// the problem; none changes by more than if the squared distance `within` were due to it alone.
std::vector<double> random_position(const AssemblyProblem& problem, std::mt19937& random,
                                    const AssemblyProblem::Squared& within = {INFINITY, INFINITY});

}  // namespace gelenk
