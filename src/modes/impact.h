// SPDX-License-Identifier: BSD-3-Clause
// Impulses of contacts that are struck at the same instant.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

// A coordinate that touches a bound.
struct StruckContact {
  int side = 0;            // 1: its upper bound, -1: its lower one
  double speed = 0;        // before the impact
  double restitution = 0;  // of this impact
  bool poisson = false;    // Poisson's law instead of Newton's
  bool held = false;       // does not leave, since it would return at once
};

struct Impact {
  Eigen::VectorXd impulses;  // along the coordinates, away from the bounds
  bool found = false;        // otherwise no velocities permit all rebounds, and the impulses are inelastic
  bool is_possible = false;  // otherwise no impulses can stop what approaches a bound
};

// W: the change of the coordinates' speeds (rows) per impulse along them (columns). Newton's law: each coordinate
// leaves with at least its restitution times the speed of its approach (Moreau 1988). Poisson's law: the impulse is at
// least (1 + restitution) times that of compression, which ends when nothing approaches any more (Glocker & Pfeiffer
// 1995). Where a law would add energy, the impulses are those nearest to it that add none.
Impact solve_impact(const Eigen::MatrixXd& W, const std::vector<StruckContact>& contacts);

}  // namespace gelenk
