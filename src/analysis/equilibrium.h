// SPDX-License-Identifier: BSD-3-Clause
// Where a mechanism stands still under given inputs.
#pragma once

#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/constrained_sensitivity.h"

namespace gelenk {

// What stands still: accelerations, in the mechanism's own lengths and time, up to this and to what rounding of the
// coordinates leaves of them, in parts of the terms that they are sums of. Of searches here and in Python, and of what
// gelenk.linearize calls no equilibrium.
inline constexpr double equilibrium_rate_tolerance = 1e-8;
inline constexpr double equilibrium_rounding_tolerance = 1e-13;  // ten times what closing loops leaves of coordinates

// None was found.
class NoEquilibrium : public std::runtime_error {
 public:
  explicit NoEquilibrium(Eigen::VectorXd left) : std::runtime_error("no equilibrium"), left(std::move(left)) {}
  Eigen::VectorXd left;  // accelerations that stay at best, of all speeds
};

// What a search needs to know of a mechanism; all of it outlives the search.
struct AtRest {
  const Mechanism& mechanism;
  const Loads& loads;
  const MobilityAnalysis& mobility;
  const std::vector<double>& u;                        // all inputs
  const std::vector<MotionLaw::Derivatives>& targets;  // of the coordinate rows
  double time = 1;                                     // s: the mechanism's own, for bounds
};

struct Rest {
  std::vector<double> q, cut_q;  // of the tree; of the cut joints, turns counted
};

// The rest that Newton's method on the independent coordinates finds from q, closed, in steps that keep the branch on
// which loops are closed, and are shortened until the next would be shorter (natural monotonicity: Deuflhard 2004,
// ch. 3). Where these lead nowhere, as from a maximum of the accelerations, it goes downhill until the pose is stable,
// as through honey, and on from there; the second time to the bottom. Directions in which nothing pulls are left as
// they are. Whether what is found is stable is not asked. gelenk.equilibrium begins with this search; what it does
// besides, poses that are held, inputs, steady motion, FMUs of any origin, is the same method in Python, by way of
// derivatives that a plant tells (python/gelenk/equilibria/newton.py).
// Throws NoEquilibrium, and Undetermined and SingularMass where q has no derivatives and does not stand still.
Rest find_rest(const AtRest& of, const std::vector<double>& q, const std::vector<double>& cut_q);

}  // namespace gelenk
