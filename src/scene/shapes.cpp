// SPDX-License-Identifier: BSD-3-Clause
#include "scene/shapes.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "scene/element_numbers.h"
#include "scene/touching_laws.h"
#include "shape/features.h"
#include "shape/kinds.h"
#include "shape/rounded.h"

namespace gelenk {
namespace {

template <class Visit>
void each_shape(const Scene& scene, Visit visit) {
  for (const Body& body : scene.bodies) {
    for (const BodyShape& shape : body.shapes) visit(shape);
  }
  for (const BodyShape& shape : scene.ground_shapes) visit(shape);
}

bool refers_to(const Contact& contact, const std::string& surface) {
  return !surface.empty() && std::ranges::find(contact.surfaces, surface) != contact.surfaces.end();
}

// Features up to which open contacts cost located events no more than steps of 1 ms, and shapes beyond which there are
// more of them.
constexpr int most_features = 1500;
constexpr std::size_t most_shapes = 60;

}  // namespace

std::string reason_for_time_steps(const Scene& scene) {
  std::size_t shapes = 0;
  each_shape(scene, [&](const BodyShape& shape) { shapes += shape.surface.empty() ? 0 : 1; });
  if (shapes > most_shapes) return "more than " + std::to_string(most_shapes) + " shapes can touch";
  int sum = 0;
  std::string not_located;
  for (const Contact& contact : scene.contacts) {
    each_pair_of_shapes(scene, contact, [&](const BodyShape& a, const BodyShape& b) {
      const int features = located_features(*a.is, *b.is);
      if (features == 0 && not_located.empty())
        not_located = "contacts." + contact.name + " is between a " + std::string(kind_of(*a.is).kind) + " and a " +
                      std::string(kind_of(*b.is).kind);
      sum += features;
    });
  }
  if (!not_located.empty() || sum <= most_features) return not_located;
  return "more than " + std::to_string(most_features) + " pairs of features can touch";
}

void scale(Stored<AnyShape>& shape, double factor) {
  const ShapeKind& kind = kind_of(*shape);
  if (kind.of_points) {
    std::vector<Eigen::Vector3d> points(points_of(*shape).begin(), points_of(*shape).end());
    for (Eigen::Vector3d& point : points) point *= factor;
    const std::span<const Triangle> triangles = triangles_of(*shape);
    shape = make_shape_of_points(static_cast<std::size_t>(&kind - shape_kinds().data()), std::move(points),
                                 {triangles.begin(), triangles.end()});
  } else {
    each_number(kind.fields, data_of(*shape), [&](const Number& x) { *x.value *= factor; });
  }
}

std::vector<std::string> surfaces_of(const Scene& scene) {
  std::vector<std::string> out;
  std::set<std::string_view> seen;
  each_shape(scene, [&](const BodyShape& shape) {
    if (!shape.surface.empty() && seen.insert(shape.surface).second) out.push_back(shape.surface);
  });
  return out;
}

MassProperties mass_properties(const std::vector<BodyShape>& shapes) {
  Spatial::Inertia sum;
  for (const BodyShape& shape : shapes) {
    const std::optional<MassProperties> of = mass_properties(*shape.is);
    if (of) sum += Spatial::Inertia::about_com(of->volume, of->center, of->inertia).moved_by(shape.X_BS);
  }
  MassProperties out;
  if (!(sum.m > 0)) return out;
  out.volume = sum.m;
  out.center = sum.h / sum.m;
  out.inertia =
      sum.I - sum.m * (out.center.squaredNorm() * Eigen::Matrix3d::Identity() - out.center * out.center.transpose());
  return out;
}

int contact_between(const Scene& scene, const std::string& a, const std::string& b) {
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const std::vector<std::string>& pair = scene.contacts[i].surfaces;
    if ((pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a)) return static_cast<int>(i);
  }
  return -1;
}

int located_features(const AnyShape& a, const AnyShape& b) {
  const auto count = [](const auto& of) { return static_cast<int>(of.size()); };
  if (tips_touch_core(a, b)) return count(tips_of(a));
  if (tips_touch_core(b, a)) return count(tips_of(b));
  constexpr int faces = 6;
  if (edges_touch(a, b))
    return faces * (count(tips_of(a)) + count(tips_of(b))) + count(edges_of(a)) * count(edges_of(b));
  if (rims_touch_plane(a, b)) return count(rims_of(a));
  return rims_touch_plane(b, a) ? count(rims_of(b)) : 0;
}

bool locates_contacts(const Scene& scene) {
  const std::string& integrator = scene.solver.integrator;
  if (!has_touching_laws(scene) || integrator == "moreau-jean") return false;
  return (integrator != "auto" && !integrator.empty()) || reason_for_time_steps(scene).empty();
}

void each_pair_of_shapes(const Scene& scene, const Contact& contact,
                         const std::function<void(const BodyShape&, const BodyShape&)>& visit) {
  if (contact.surfaces.size() < 2) return;
  std::vector<std::pair<std::string, const BodyShape*>> shapes;  // with their bodies
  for (const Body& body : scene.bodies) {
    for (const BodyShape& shape : body.shapes) shapes.emplace_back(body.name, &shape);
  }
  for (const BodyShape& shape : scene.ground_shapes) shapes.emplace_back(std::string(ground), &shape);
  const auto are_joined = [&](const std::string& a, const std::string& b) {
    if (includes_joined(*contact.is) || a == ground || b == ground) return false;
    return std::ranges::any_of(scene.joints, [&](const Joint& joint) {
      const std::string& parent = joint.parent.body;
      const std::string& child = joint.child.body;
      return kind_of(*joint.is).nv < 6 && ((parent == a && child == b) || (parent == b && child == a));
    });
  };
  for (const auto& [a, first] : shapes) {
    for (const auto& [b, second] : shapes) {
      const bool fits = first->surface == contact.surfaces[0] && second->surface == contact.surfaces[1];
      if (fits && a != b && !are_joined(a, b)) visit(*first, *second);
    }
  }
}

std::vector<bool> bodies_that_touch(const Scene& scene) {
  std::vector<bool> out(scene.bodies.size(), false);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    for (const BodyShape& shape : scene.bodies[b].shapes) {
      out[b] = out[b] || std::ranges::any_of(scene.contacts,
                                             [&](const Contact& contact) { return refers_to(contact, shape.surface); });
    }
  }
  return out;
}

}  // namespace gelenk
