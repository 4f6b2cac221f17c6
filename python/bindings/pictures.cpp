// SPDX-License-Identifier: BSD-3-Clause
// What pictures show of a scene and of a simulation: the shapes of bodies, and what acts on them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <vector>

#include "bindings.h"
#include "outputs/wrenches.h"
#include "plant.h"
#include "scene/scene.h"
#include "shape/kinds.h"

namespace nb = nanobind;

namespace {

nb::list drawn(const std::vector<gelenk::BodyShape>& shapes, double extent) {
  nb::list out;
  for (const gelenk::BodyShape& shape : shapes) {
    const auto placed = [&](const Eigen::Vector3d& p_S) {
      const Eigen::Vector3d p = shape.X_BS.point(p_S);
      return nb::make_tuple(p.x(), p.y(), p.z());
    };
    const gelenk::Drawing of = gelenk::drawing_of(*shape.is, extent);
    nb::list balls, tubes, vertices, triangles;
    for (const auto& ball : of.balls) balls.append(nb::make_tuple(placed(ball.center), ball.radius));
    for (const auto& tube : of.tubes) tubes.append(nb::make_tuple(placed(tube.from), placed(tube.to), tube.radius));
    for (const Eigen::Vector3d& p : of.points) vertices.append(placed(p));
    for (const gelenk::Triangle& t : of.triangles) triangles.append(nb::make_tuple(t[0], t[1], t[2]));
    out.append(nb::make_tuple(balls, tubes, vertices, triangles));
  }
  return out;
}

nb::dict drawings(const gelenk::Scene& scene, double extent) {
  nb::dict out;
  for (const gelenk::Body& body : scene.bodies) out[body.name.c_str()] = drawn(body.shapes, extent);
  out[gelenk::ground] = drawn(scene.ground_shapes, extent);
  return out;
}

nb::list wrenches(gelenk::SharedSimulation& plant) {
  static constexpr const char* kinds[] = {"load", "reaction", "contact"};
  const std::vector<gelenk::Body>& bodies = plant.fixed().scene().bodies;
  nb::list out;
  for (const gelenk::BodyWrench& of : plant.with([](gelenk::Simulation& s) { return s.wrenches(); })) {
    std::vector<double> numbers;
    for (const Eigen::Vector3d* part : {&of.p, &of.f, &of.n}) numbers.insert(numbers.end(), part->begin(), part->end());
    out.append(nb::make_tuple(kinds[static_cast<int>(of.kind)], of.name,
                              of.body < 0 ? gelenk::ground : bodies[static_cast<std::size_t>(of.body)].name.c_str(),
                              of.place, numbers));
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
