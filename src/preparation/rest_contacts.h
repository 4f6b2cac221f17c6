// SPDX-License-Identifier: BSD-3-Clause
// What contacts of shapes have to do to keep a mechanism at rest.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/equilibrium.h"
#include "dynamics/dynamics.h"
#include "scene/scene.h"

namespace gelenk {

// A point at which two shapes touch at rest, in SI units.
struct RestPoint {
  std::string contact, first, second;                  // names; of the bodies, with its first and its second surface
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // in the world
  Eigen::Vector3d force = Eigen::Vector3d::Zero();     // on the body with the first surface, in the world
  double normal = 0, friction = 0, limit = 0;  // parts of the force; the largest friction under this normal force
};

struct RestContacts {
  std::vector<RestPoint> points{};
  bool can_push = true;   // no point has to pull
  bool is_held = true;    // and the forces are within the laws
  std::string undefined;  // a contact that is closed, but has no points that remain if it moves; empty: none
};

// Of everything that touches at the position of `dynamics`, at rest, after solve(): adds their effect to vdot, in which
// everything sticks that has friction. Where the forces are redundant, they are those of least norm, with friction in
// proportion to normal forces or, if these are outside the laws, those furthest inside them.
RestContacts rest_contacts(const Scene& scene, const EquilibriumProblem& of, Dynamics& dynamics, double* vdot);

}  // namespace gelenk
