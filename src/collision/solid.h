// SPDX-License-Identifier: BSD-3-Clause
// A polyhedron at a pose: a hull, or a box as a scaled cube.
#pragma once

#include "shape/box.h"
#include "shape/hull.h"

namespace gelenk {

class Solid {
 public:
  Solid(const Hull& hull, const Pose3& X)
      : shape_(&hull.polyhedron()), scale_(Eigen::Vector3d::Ones()), X_(X), size_(hull.size()) {}
  // Vertices of a box are its corners, Box::corner().
  Solid(const Box& box, const Pose3& X);

  const Polyhedron& shape() const { return *shape_; }
  double size() const { return size_; }
  int face_count() const { return static_cast<int>(shape_->faces.size()); }

  Eigen::Vector3d vertex(int i) const {
    return X_.p + X_.R * scale_.cwiseProduct(shape_->vertices[static_cast<std::size_t>(i)]);
  }
  Eigen::Vector3d normal(int face) const { return X_.R * shape_->faces[static_cast<std::size_t>(face)].normal; }
  std::span<const int> loop(int face) const { return shape_->loop(static_cast<std::size_t>(face)); }
  // Height of x above the plane of a face with this normal.
  double height(int face, const Eigen::Vector3d& normal, const Eigen::Vector3d& x) const {
    return normal.dot(x - vertex(loop(face)[0]));
  }

  // Vertex farthest in the direction d.
  int farthest(const Eigen::Vector3d& d) const { return shape_->farthest(scale_.cwiseProduct(X_.R.transpose() * d)); }
  // Face whose normal is closest to d.
  int face_toward(const Eigen::Vector3d& d) const;
  // Whether the projection of x on a face is within it, or outside by at most `slack`.
  bool covers(int face, const Eigen::Vector3d& normal, const Eigen::Vector3d& x, double slack) const;

  // Numbers of features: vertices, then edges, then faces.
  int edge_feature(int edge) const { return static_cast<int>(shape_->vertices.size()) + edge; }
  int face_feature(int face) const { return edge_feature(static_cast<int>(shape_->edges.size()) + face); }
  int feature_count() const { return face_feature(face_count()); }
  // Edge from vertex loop(face)[place] to its successor.
  int edge_at(int face, std::size_t place) const {
    const auto first = static_cast<std::size_t>(shape_->faces[static_cast<std::size_t>(face)].first);
    return shape_->loop_edges[first + place];
  }
  // Edge between two vertices, or -1.
  int edge_between(int a, int b) const;

 private:
  const Polyhedron* shape_;
  Eigen::Vector3d scale_;
  Pose3 X_;
  double size_;
};

}  // namespace gelenk
