// SPDX-License-Identifier: BSD-3-Clause
// How far contact forces are inside their laws, where redundant ones may be distributed in any way.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

// Singular values below this fraction of the largest belong to redundant forces: those of redundant rows are rounding,
// about 1e-15; those of rows that are nearly parallel, as of corners 1e-4 apart on a body, are above 1e-9.
inline constexpr double redundancy = 1e-11;

// The multipliers x with G x = 0, orthonormal, in columns; G: what they do to what is kept.
Eigen::MatrixXd redundant_multipliers(const Eigen::MatrixXd& G);

// Rows of multipliers: a normal force and forces or moments of friction, at most `coefficient` times it.
struct ForceCone {
  int normal = 0;
  int first = 0, size = 0;  // of friction; size 0: the normal force alone has to push
  double coefficient = 0;
};

struct ForceMargin {
  // The largest s for which all cones contain the forces with all normal forces reduced by s, if it is below `enough`;
  // otherwise some value above.
  double margin = 0;
  std::size_t cone = 0;  // that permits no more
  Eigen::VectorXd x{};   // these forces
};

// x: multipliers; redundant: those without effect, in columns, which may be added. By a barrier method: Nesterov &
// Nemirovskii (1994), Interior-Point Polynomial Algorithms in Convex Programming, ch. 2 and 5.
ForceMargin force_margin(const Eigen::VectorXd& x, const Eigen::MatrixXd& redundant,
                         const std::vector<ForceCone>& cones, double enough);

}  // namespace gelenk
