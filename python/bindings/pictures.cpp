// SPDX-License-Identifier: BSD-3-Clause
// What pictures show of a scene and of a simulation: the shapes of bodies, and what acts on them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "bindings.h"
#include "outputs/wrenches.h"
#include "plant.h"
#include "scene/scene.h"
#include "shape/kinds.h"

namespace nb = nanobind;

namespace {

using Point = std::tuple<double, double, double>;
using Ball = std::tuple<Point, double>;
using Tube = std::tuple<Point, Point, double>;
using Drawn =
    std::tuple<std::vector<Ball>, std::vector<Tube>, std::vector<Point>, std::vector<std::tuple<int, int, int>>>;
using Wrench = std::tuple<std::string, std::string, std::string, int, std::vector<double>>;

std::vector<Drawn> drawn(const std::vector<gelenk::BodyShape>& shapes, double extent) {
  std::vector<Drawn> out;
  for (const gelenk::BodyShape& shape : shapes) {
    const auto placed = [&](const Eigen::Vector3d& p_S) {
      const Eigen::Vector3d p = shape.X_BS.point(p_S);
      return Point(p.x(), p.y(), p.z());
    };
    const gelenk::Drawing of = gelenk::drawing_of(*shape.is, extent);
    auto& [balls, tubes, vertices, triangles] = out.emplace_back();
    for (const auto& ball : of.balls) balls.emplace_back(placed(ball.center), ball.radius);
    for (const auto& tube : of.tubes) tubes.emplace_back(placed(tube.from), placed(tube.to), tube.radius);
    for (const Eigen::Vector3d& p : of.points) vertices.push_back(placed(p));
    for (const gelenk::Triangle& t : of.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  }
  return out;
}

std::map<std::string, std::vector<Drawn>> drawings(const gelenk::Scene& scene, double extent) {
  std::map<std::string, std::vector<Drawn>> out;
  for (const gelenk::Body& body : scene.bodies) out[body.name] = drawn(body.shapes, extent);
  out[gelenk::ground] = drawn(scene.ground_shapes, extent);
  return out;
}

std::vector<Wrench> wrenches(gelenk::SharedSimulation& plant) {
  static constexpr const char* kinds[] = {"load", "reaction", "contact"};
  const std::vector<gelenk::Body>& bodies = plant.fixed().scene().bodies;
  std::vector<Wrench> out;
  for (const gelenk::BodyWrench& of : plant.with([](gelenk::Simulation& s) { return s.wrenches(); })) {
    std::vector<double> numbers;
    for (const Eigen::Vector3d* part : {&of.p, &of.f, &of.n}) numbers.insert(numbers.end(), part->begin(), part->end());
    out.emplace_back(kinds[static_cast<int>(of.kind)], of.name,
                     of.body < 0 ? gelenk::ground : bodies[static_cast<std::size_t>(of.body)].name, of.place, numbers);
  }
  return out;
}

}  // namespace

void gelenk::bind_pictures(nb::module_& m) {
  m.def("drawings", &drawings, nb::arg("scene"), nb::arg("extent"),
        "What is drawn of the shapes of each body and of the ground, in its frame: balls (center, radius), tubes (two "
        "ends, radius), vertices and triangles of each shape. extent [m]: the edge of pieces of half-spaces.");
  m.def("wrenches", &wrenches, nb::arg("simulation"),
        "What elements exert on bodies: kind, name of the element, body, port or other body, and nine numbers: where "
        "it acts [m] in the body's frame, force [N] and torque [N.m] in the world's axes.");
}
