// SPDX-License-Identifier: BSD-3-Clause
#include "shape/registry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "util/stored_impl.h"

namespace gelenk {
namespace {

template <class S>
constexpr bool made_of_points = requires(const S& shape) { shape.points(); };
template <class S>
constexpr bool made_of_triangles = requires(const S& shape) { shape.triangles(); };

template <class S>
ShapeKind describe() {
  ShapeKind out{.kind = S::kind,
                .summary = S::summary,
                .fields = S::fields(),
                .bounded = S::bounded,
                .of_points = made_of_points<S>,
                .of_triangles = made_of_triangles<S>};
  if constexpr (requires(const S& shape) { shape.fault(); })
    out.fault = [](const void* shape) { return static_cast<const S*>(shape)->fault(); };
  return out;
}

template <class... S>
auto describe_all(const std::variant<S...>*) {
  return std::array<ShapeKind, sizeof...(S)>{describe<S>()...};
}

template <class... S>
AnyShape make_nth(std::size_t n, const std::variant<S...>*) {
  using Make = AnyShape (*)();
  static constexpr std::array<Make, sizeof...(S)> makers = {[] { return AnyShape(S{}); }...};
  return makers.at(n)();
}

// Points farthest in directions all around, every 7.5 degrees about z and 15 degrees towards it.
std::vector<Eigen::Vector3d> outermost_points(const AnyShape& shape) {
  constexpr int around = 48, across = 12;
  constexpr double pi = std::numbers::pi;
  std::vector<Eigen::Vector3d> out;
  for (int j = 0; j <= across; ++j) {
    const double height = pi * (static_cast<double>(j) / across - 0.5);
    for (int i = 0; i < around; ++i) {
      const double turn = 2 * pi * i / around;
      out.push_back(
          *support(shape, {std::cos(turn) * std::cos(height), std::sin(turn) * std::cos(height), std::sin(height)}));
    }
  }
  return out;
}

}  // namespace

std::span<const ShapeKind> shape_kinds() {
  static const auto kinds = describe_all(static_cast<const AnyShape*>(nullptr));
  return kinds;
}

const ShapeKind* find_shape_kind(std::string_view name) {
  const auto kinds = shape_kinds();
  const auto found = std::ranges::find(kinds, name, &ShapeKind::kind);
  return found == kinds.end() ? nullptr : &*found;
}

template class Stored<AnyShape>;

void* data_of(AnyShape& shape) {
  return std::visit([](auto& s) -> void* { return &s; }, shape);
}
const void* data_of(const AnyShape& shape) {
  return std::visit([](const auto& s) -> const void* { return &s; }, shape);
}

const ShapeKind& kind_of(const AnyShape& shape) { return shape_kinds()[shape.index()]; }

Stored<AnyShape> make_shape(std::size_t n) { return make_nth(n, static_cast<const AnyShape*>(nullptr)); }

Stored<AnyShape> make_shape_of_points(std::size_t n, std::vector<Eigen::Vector3d> points,
                                      std::vector<Triangle> triangles) {
  Stored<AnyShape> out = make_shape(n);
  std::visit(
      [&](auto& shape) {
        using S = std::decay_t<decltype(shape)>;
        if constexpr (made_of_triangles<S>) {
          shape = S(std::move(points), std::move(triangles));
        } else if constexpr (made_of_points<S>) {
          shape = S(std::move(points));
        }
      },
      *out);
  return out;
}

std::span<const Eigen::Vector3d> points_of(const AnyShape& shape) {
  return std::visit(
      [](const auto& s) -> std::span<const Eigen::Vector3d> {
        if constexpr (made_of_points<std::decay_t<decltype(s)>>) return s.points();
        return {};
      },
      shape);
}

std::span<const Triangle> triangles_of(const AnyShape& shape) {
  return std::visit(
      [](const auto& s) -> std::span<const Triangle> {
        if constexpr (made_of_triangles<std::decay_t<decltype(s)>>) return s.triangles();
        return {};
      },
      shape);
}

std::optional<MassProperties> mass_properties(const AnyShape& shape) {
  return std::visit(
      [](const auto& s) -> std::optional<MassProperties> {
        if constexpr (std::decay_t<decltype(s)>::bounded) return s.mass_properties();
        return std::nullopt;
      },
      shape);
}

std::optional<Eigen::Vector3d> support(const AnyShape& shape, const Eigen::Vector3d& d) {
  return std::visit(
      [&](const auto& s) -> std::optional<Eigen::Vector3d> {
        if constexpr (std::decay_t<decltype(s)>::bounded) return s.support(d);
        return std::nullopt;
      },
      shape);
}

double size_of(const AnyShape& shape) {
  return std::visit(
      [](const auto& s) {
        if constexpr (std::decay_t<decltype(s)>::bounded) return s.size();
        return std::numeric_limits<double>::infinity();
      },
      shape);
}

Drawing drawing_of(const AnyShape& shape, double extent) {
  Drawing out = std::visit(
      [&](const auto& s) -> Drawing {
        if constexpr (requires { s.drawn(extent); }) return s.drawn(extent);
        return {};
      },
      shape);
  const bool is_empty = out.balls.empty() && out.tubes.empty() && out.points.empty();
  if (is_empty && kind_of(shape).bounded) out.points = outermost_points(shape);
  if (!out.triangles.empty() || out.points.empty()) return out;
  Polyhedron hull = convex_hull(out.points);
  out.triangles = triangles_of(hull);
  out.points = std::move(hull.vertices);
  return out;
}

Aabb bounds(const AnyShape& shape, const Pose3& X_WS) {
  return std::visit([&](const auto& s) { return s.bounds(X_WS); }, shape);
}

}  // namespace gelenk
