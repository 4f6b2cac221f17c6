// SPDX-License-Identifier: BSD-3-Clause
// Cone problems in which other impulses have the same effect, as at the corners of a box, or along the normal and the
// tangent of a point that can move in one direction only: how they are shared decides on friction, must not depend on
// rounding, and may keep other methods from converging. Contacts that yield a little have unique impulses, nearly those
// of least norm; what they yield is removed by proximal iterations (Rockafellar 1976).
#pragma once

#include <Eigen/Core>
#include <span>

#include "complementarity/cone.h"

namespace gelenk {

// By row: how much it yields if impulses are redundant; empty if they are unique. Equal for what a turn of the axes
// mixes.
Eigen::VectorXd yielding_weights(const Eigen::Ref<const Eigen::MatrixXd>& G, std::span<const Cone> cones);

// x <- the impulses, not from an initial guess. options: of each iteration; most_iterations: of the solver, in all.
ConeResult solve_redundant(ConeSolver& solver, const Eigen::Ref<const Eigen::MatrixXd>& G,
                           const Eigen::VectorXd& weights, const Eigen::Ref<const Eigen::VectorXd>& b,
                           std::span<const Cone> cones, const ConeOptions& options, int most_iterations, double* x);

// Where a solver has not converged, maybe since impulses are redundant: `found`, or a better solution. x: that of
// `found`. Only of small problems, with up to ten times as many iterations as the options permit.
ConeResult improve_redundant(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options,
                             const ConeResult& found, double* x);

}  // namespace gelenk
