// SPDX-License-Identifier: BSD-3-Clause
// The list of all shapes. A new shape requires a header and its name in AnyShape, and a routine for contacts in
// src/collision.
#pragma once

#include <variant>

#include "shape/box.h"
#include "shape/capsule.h"
#include "shape/cylinder.h"
#include "shape/hull.h"
#include "shape/kinds.h"
#include "shape/mesh.h"
#include "shape/plane.h"
#include "shape/sphere.h"
#include "shape/wheel.h"

namespace gelenk {

struct AnyShape : std::variant<Sphere, Capsule, Box, Cylinder, Plane, Hull, Mesh, Wheel> {
  using variant::variant;
};

}  // namespace gelenk
