// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/inertia.h"

#include <algorithm>

#include "decomposition/dense.h"
#include "preparation/preparation.h"

namespace gelenk {
namespace {

Scene without_rods(const Scene& scene) {
  Scene out = scene;
  out.solver.reductions[static_cast<std::size_t>(Reduction::massless)] = false;
  return out;
}

}  // namespace

std::vector<bool> islands_with_rods(const ReducedScene& reduced) {
  std::vector<bool> out(reduced.islands.size(), false);
  for (const JointPlace& joint : reduced.joints) {
    if (joint.role == JointPlace::Role::rod) out[joint.island] = true;
  }
  return out;
}

bool has_rods(const ReducedScene& reduced) {
  return std::ranges::any_of(reduced.joints, [](const JointPlace& j) { return j.role == JointPlace::Role::rod; });
}

void give_inertia(Mechanism& mechanism) {
  mechanism.mass_needs_rows = false;
  for (Link& link : mechanism.links) {
    link.G = Spatial::Inertia::about_com(1, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  }
}

bool lacks_inertia(const Mechanism& mechanism) {
  return std::any_of(mechanism.links.begin() + 1, mechanism.links.end(), [&](const Link& link) {
    const Spatial::Inertia& G = link.G;
    if (G.m <= 0) return true;
    const Eigen::Vector3d c = G.h / G.m;
    const Eigen::Matrix3d I = G.I - G.m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    const double min_inertia = 1e-9 * G.I.norm();  // subtraction leaves about 1e-16 of it
    if (mechanism.planar) return I(2, 2) <= min_inertia;
    return symmetric_eigenvalues(I)[0] <= min_inertia;
  });
}

ReducedScene reduce_to_geometry(const Scene& scene) {
  ReducedScene out = reduce(without_rods(scene));
  for (Mechanism& mechanism : out.islands) give_inertia(mechanism);
  return out;
}

}  // namespace gelenk
