// SPDX-License-Identifier: BSD-3-Clause
// Centers of mass and inertias that do not fit the size of the mechanism: millimeters, grams or square millimeters
// among meters and kilograms.
#include <algorithm>
#include <cmath>
#include <map>

#include "check/warnings.h"
#include "shape/kinds.h"
#include "util/text.h"

namespace gelenk {
namespace {

// A center of mass may be this far from the frame of its body, and the radius of gyration this large, in sizes of the
// mechanism. Inertias of rotors, which gears reflect with the square of their ratio, remain below; millimeters do not.
constexpr double max_ratio = 30;

using Distances = std::map<std::string, double>;

// Returns for each body the largest distance of a joint or a corner of a shape from its frame [m].
Distances extents(const Scene& scene) {
  Distances out;
  const auto include = [&](const std::string& body, double distance) {
    if (std::isfinite(distance)) out[body] = std::max(out[body], distance);
  };
  for (const Joint& joint : scene.joints) {
    for (const BodyFrame* frame : {&joint.parent, &joint.child}) include(frame->body, frame->X_BF.p.norm());
  }
  for (const Body& body : scene.bodies) {
    for (const BodyShape& shape : body.shapes) {
      const Aabb box = bounds(*shape.is, shape.X_BS);
      include(body.name, box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm());
    }
  }
  return out;
}

void warn_about_com(const Body& body, double size, const std::string& path, Faults& faults) {
  const double distance = body.com.norm();
  if (!(distance > max_ratio * size)) return;
  faults.warn(path + ".com",
              "a center of mass " + text::rounded(distance, 3) + " m from the origin of the body's frame",
              "about the size of the mechanism, " + text::rounded(size, 3) + " m; " + text::rounded(distance, 3) +
                  " mm are " + text::rounded(distance / 1000, 3) + " m");
}

void warn_about_inertia(const Body& body, double size, const std::string& path, Faults& faults) {
  const double largest = body.inertia.diagonal().maxCoeff();
  const double radius = std::sqrt(largest / body.mass);
  if (!(radius > max_ratio * size)) return;
  faults.warn(path + ".inertia",
              text::rounded(largest) + " kg m2, a radius of gyration of " + text::rounded(radius, 3) + " m for " +
                  text::rounded(body.mass) + " kg",
              "one of about the size of the mechanism, " + text::rounded(size, 3) + " m; " + text::rounded(largest) +
                  " kg mm2 are " + text::rounded(largest * 1e-6) + " kg m2");
}

}  // namespace

// The size for one body is that of its own joints and shapes, and of everything about the others: one wrong number does
// not hide itself.
void warn_about_sizes(const Scene& scene, Faults& faults) {
  const Distances extent = extents(scene);
  const auto extent_of = [&](const std::string& name) {
    const auto found = extent.find(name);
    return found == extent.end() ? 0.0 : found->second;
  };
  double largest = extent_of(ground);
  for (const auto& [name, distance] : extent) largest = std::max(largest, distance);
  // The two largest distances of centers of mass, so that the largest among the other bodies is known for each.
  double first = 0;
  double second = 0;
  for (const Body& body : scene.bodies) {
    const double distance = body.mass > 0 ? body.com.norm() : 0;
    second = std::max(second, std::min(first, distance));
    first = std::max(first, distance);
  }
  for (const Body& body : scene.bodies) {
    if (!(body.mass > 0)) continue;  // a center of mass without mass has no effect
    const double distance = body.com.norm();
    const double others = std::max(largest, distance == first ? second : first);
    const std::string path = "bodies." + body.name;
    if (others > 0) warn_about_com(body, others, path, faults);
    const double all = std::max(others, distance);
    if (all > 0) warn_about_inertia(body, all, path, faults);
  }
}

}  // namespace gelenk
