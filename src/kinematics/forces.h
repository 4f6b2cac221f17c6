// SPDX-License-Identifier: BSD-3-Clause
// Forces on links, for what does not depend on their kinds; the kernels are in load_kernels.h.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "field/formula.h"
#include "kinematics/readings.h"
#include "math/spatial.h"
#include "util/stored.h"

namespace gelenk {

struct AnyForce;
struct GravityField;
struct PlacedForces;  // by kind: placed_forces.h
template <class F>
struct PlacedForce;
extern template class Stored<PlacedForces>;

// A frame on a link. In planar mechanisms its height above the plane is height + p.z().
struct Attachment {
  int link = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      // m, in the link's frame
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // its axes, in the link's
  double height = 0;                                // m, of the link's origin along the plane's normal; 0 in space
};

// Removes all forces; the lists keep their capacity.
void clear_forces(PlacedForces& forces);
// Adds one that acts on these frames. input: index of its first input in the scene; index: its own in the scene.
void add_force(PlacedForces& forces, const AnyForce& force, std::span<const Attachment> at, int input, int index);
// The same for gravity that depends on the position, on a body with this mass at its center of mass.
void add_gravity(PlacedForces& forces, const GravityField& field, double mass, const Attachment& at);
bool is_empty(const PlacedForces& forces);

// Marks the links on whose poses a force depends.
void mark_links(const PlacedForces& forces, std::vector<bool>& marked);

// Calls visit(formula, force) for each expression of forces; force: index in the scene, -1: gravity.
using VisitFormula = std::function<void(Formula&, int force)>;
void each_formula(PlacedForces& forces, const VisitFormula& visit);
// The same for constant ones.
void each_formula(const PlacedForces& forces, const std::function<void(const Formula&, int force)>& visit);

// By force, in the order in which they act: the links on which it acts, the first of a single one being the root.
struct LinksOfForce {
  int a, b;
};
std::vector<LinksOfForce> links_of(const PlacedForces& forces);

// The index in the scene of a force whose direction is undefined at the current position, such as that of a spring
// between two coincident points; -1 if there is none. at: after set_root_poses().
int undefined_force(const PlacedForces& forces, const Readings<double>& at);

// Potential energy [J] of a force whose ports are at these poses in the world.
double energy_at(const AnyForce& force, std::span<const Pose3> X_WP);

}  // namespace gelenk
