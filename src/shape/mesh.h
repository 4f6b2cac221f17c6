// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "shape/hull.h"

namespace gelenk {

// A solid bounded by triangles, which need not be convex; its contacts are those of its convex hull. Copies share the
// data, which never change.
struct Mesh {
  static constexpr std::string_view kind = "mesh";
  static constexpr std::string_view summary = "a solid bounded by triangles; it touches others as its convex hull";
  static constexpr bool bounded = true;

  // A tetrahedron with edges along the axes, as a default value.
  Mesh();
  // Throws std::invalid_argument with a sentence if the surface is not closed (mass_properties_of_mesh()), or if its
  // points span no volume.
  Mesh(std::vector<Eigen::Vector3d> points, std::vector<Triangle> triangles);

  static std::span<const Field> fields() { return {}; }

  const std::vector<Eigen::Vector3d>& points() const { return data_->points; }  // as given
  const std::vector<Triangle>& triangles() const { return data_->triangles; }
  const Hull& hull() const { return data_->hull; }

  const MassProperties& mass_properties() const { return data_->mass; }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const { return hull().support(d); }
  Drawing drawn(double) const { return {.points = points(), .triangles = triangles()}; }
  double size() const { return hull().size(); }
  Aabb bounds(const Pose3& X_WS) const { return hull().bounds(X_WS); }

 private:
  struct Data {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    Hull hull;  // of the points that belong to triangles
    MassProperties mass;
  };
  std::shared_ptr<const Data> data_;
};

}  // namespace gelenk
