// SPDX-License-Identifier: BSD-3-Clause
#include <set>

#include "check/check.h"
#include "check/fields.h"
#include "scene/scene.h"
#include "util/text.h"

namespace gelenk {
namespace {

void check_shapes(const Scene& scene, const std::vector<BodyShape>& shapes, const std::string& owner, bool of_body,
                  Faults& faults, bool partial) {
  std::set<std::string> names;
  for (const BodyShape& shape : shapes) {
    const std::string path = owner + ".shapes." + text::printable(shape.name);
    const ShapeKind& kind = kind_of(*shape.is);
    if (!names.insert(shape.name).second) faults.add(path, "twice", "every name once");
    if (of_body && !kind.bounded)
      faults.add(path, std::string(kind.kind), "a shape of finite size; a plane is a shape of the ground");
    check_frame({.body = ground, .X_BF = shape.X_BS}, scene, path, faults, partial);
    if (!partial) {
      const auto fault = [&] { return kind.fault ? kind.fault(data_of(*shape.is)) : std::optional<ElementFault>(); };
      check_element(kind.fields, data_of(*shape.is), path, {}, fault, faults);
    }
  }
}

}  // namespace

void check_shapes(const Scene& scene, Faults& faults, bool partial) {
  for (const Body& body : scene.bodies) {
    check_shapes(scene, body.shapes, "bodies." + text::printable(body.name), true, faults, partial);
  }
  check_shapes(scene, scene.ground_shapes, ground, false, faults, partial);
}

}  // namespace gelenk
