// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "shape/polyhedron.h"

namespace gelenk {

// The convex hull of points. Copies share the polyhedron, which never changes.
struct Hull {
  static constexpr std::string_view kind = "hull";
  static constexpr std::string_view summary = "the convex hull of points";
  static constexpr bool bounded = true;

  // A tetrahedron with edges along the axes, as a default value.
  Hull();
  // Throws std::invalid_argument with a sentence if the points span no volume (shape/polyhedron.h).
  explicit Hull(std::vector<Eigen::Vector3d> points);

  static std::span<const Field> fields() { return {}; }

  const std::vector<Eigen::Vector3d>& points() const { return data_->points; }  // as given
  const Polyhedron& polyhedron() const { return data_->polyhedron; }

  const MassProperties& mass_properties() const { return data_->mass; }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    return polyhedron().vertices[static_cast<std::size_t>(polyhedron().farthest(d))];
  }
  Drawing drawn(double) const { return {.points = polyhedron().vertices}; }
  double size() const { return data_->size; }
  Aabb bounds(const Pose3& X_WS) const;

 private:
  struct Data {
    std::vector<Eigen::Vector3d> points;
    Polyhedron polyhedron;
    MassProperties mass;
    double size = 0;
  };
  std::shared_ptr<const Data> data_;
};

}  // namespace gelenk
