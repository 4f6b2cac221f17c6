// SPDX-License-Identifier: BSD-3-Clause
#include "shape/features.h"

#include "shape/registry.h"
#include "shape/rounded.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

std::vector<SolidEdge> edges(const Box& box) {
  std::vector<SolidEdge> out;
  const Vector3d half = box.lengths / 2;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-1.0, 1.0}) {
        SolidEdge& edge = out.emplace_back();
        edge.direction = Vector3d::Unit(k);
        edge.center = a * half[i] * Vector3d::Unit(i) + b * half[j] * Vector3d::Unit(j);
        edge.half = half[k];
        edge.normals = {a * Vector3d::Unit(i), b * Vector3d::Unit(j)};
      }
    }
  }
  return out;
}
std::vector<SolidEdge> edges(const Capsule& capsule) {
  SolidEdge axis;
  axis.direction = Vector3d::UnitZ();
  axis.half = capsule.length / 2;
  axis.radius = capsule.radius;
  axis.normals = {Vector3d::Zero(), Vector3d::Zero()};
  return {axis};
}
template <class Shape>
std::vector<SolidEdge> edges(const Shape&) {
  return {};
}

std::vector<SolidRim> rims(const Cylinder& cylinder) {
  return {{{0, 0, -cylinder.length / 2}, Vector3d::UnitZ(), cylinder.radius, 0},
          {{0, 0, cylinder.length / 2}, Vector3d::UnitZ(), cylinder.radius, 0}};
}
std::vector<SolidRim> rims(const Wheel& wheel) {
  return {{Vector3d::Zero(), Vector3d::UnitZ(), wheel.disk(), wheel.crown}};
}
template <class Shape>
std::vector<SolidRim> rims(const Shape&) {
  return {};
}

}  // namespace

std::vector<SolidEdge> edges_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return edges(s); }, shape);
}

std::vector<SolidRim> rims_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return rims(s); }, shape);
}

bool edges_touch(const AnyShape& a, const AnyShape& b) { return !edges_of(a).empty() && !edges_of(b).empty(); }

bool rims_touch_plane(const AnyShape& of_rims, const AnyShape& plane) {
  const std::optional<RoundedBox> core = core_of(plane);
  return core && core->half_space && !rims_of(of_rims).empty();
}

}  // namespace gelenk
