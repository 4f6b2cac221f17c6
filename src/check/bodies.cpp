// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "check/check.h"
#include "math/rotations.h"
#include "util/text.h"

namespace gelenk {

void check_bodies(const Scene& scene, Faults& faults, bool partial) {
  for (const Body& body : scene.bodies) {
    const std::string path = "bodies." + text::printable(body.name);
    if (!partial || !std::isnan(body.mass)) check_finite(&body.mass, 1, path + ".mass", faults);
    if (body.mass < 0) faults.add(path + ".mass", text::number(body.mass) + " kg", "0 kg or more");
    check_finite(body.com.data(), 3, path + ".com", faults);
    if (body.pose) check_frame({.body = ground, .X_BF = *body.pose}, scene, path + ".pose", faults, partial);
  }
  check_inertias(scene, faults, partial);
}

}  // namespace gelenk
