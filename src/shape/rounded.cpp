// SPDX-License-Identifier: BSD-3-Clause
#include "shape/rounded.h"

#include "shape/registry.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

std::optional<RoundedBox> core(const Sphere& sphere) { return RoundedBox{Vector3d::Zero(), sphere.radius, false}; }
std::optional<RoundedBox> core(const Capsule& capsule) {
  return RoundedBox{{0, 0, capsule.length / 2}, capsule.radius, false};
}
std::optional<RoundedBox> core(const Box& box) { return RoundedBox{box.lengths / 2, 0, false}; }
std::optional<RoundedBox> core(const Plane&) { return RoundedBox{Vector3d::Zero(), 0, true}; }
template <class Shape>
std::optional<RoundedBox> core(const Shape&) {
  return std::nullopt;
}

std::vector<Tip> tips(const Sphere& sphere) { return {{Vector3d::Zero(), sphere.radius, 0}}; }
std::vector<Tip> tips(const Capsule& capsule) {
  return {{{0, 0, -capsule.length / 2}, capsule.radius, 0}, {{0, 0, capsule.length / 2}, capsule.radius, 1}};
}
std::vector<Tip> tips(const Box& box) {
  std::vector<Tip> out;
  for (int i = 0; i < 8; ++i) out.push_back({box.corner(i), 0, i});
  return out;
}
std::vector<Tip> tips(const Hull& hull) {
  std::vector<Tip> out;
  for (const Vector3d& vertex : hull.polyhedron().vertices) out.push_back({vertex, 0, static_cast<int>(out.size())});
  return out;
}
template <class Shape>
std::vector<Tip> tips(const Shape&) {
  return {};
}

}  // namespace

std::optional<RoundedBox> core_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return core(s); }, shape);
}

std::vector<Tip> tips_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return tips(s); }, shape);
}

bool tips_touch_core(const AnyShape& of_tips, const AnyShape& of_core) {
  const std::optional<RoundedBox> core = core_of(of_core);
  if (!core || tips_of(of_tips).empty()) return false;
  const std::optional<RoundedBox> other = core_of(of_tips);
  return core->half_space || (other && other->is_ball());
}

}  // namespace gelenk
