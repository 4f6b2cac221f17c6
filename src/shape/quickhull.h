// SPDX-License-Identifier: BSD-3-Clause
// The quickhull algorithm in space (Barber, Dobkin & Huhdanpaa 1996): triangles around a set of points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace gelenk {

class Quickhull {
 public:
  // A triangle with its points counterclockwise as seen from outside; neighbor[i] is the facet beyond the edge from
  // vertex[i] to its successor.
  struct Facet {
    std::array<int, 3> vertex{}, neighbor{};
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset = 0;
    double area = 0;
    std::vector<int> outside;  // points above this facet that are not yet part of the hull
    bool removed = false;
  };

  // tolerance: points closer to a facet than this distance [m] are on it.
  Quickhull(std::span<const Eigen::Vector3d> points, double tolerance) : points_(points), tolerance_(tolerance) {}

  // Adds all points; returns the facets, or none if the tolerance is too small for the rounding errors of this set or
  // too large for its thickness.
  std::optional<std::vector<Facet>> run();

 private:
  const Eigen::Vector3d& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  Facet& facet(int f) { return facets_[static_cast<std::size_t>(f)]; }
  double height(const Facet& of, const Eigen::Vector3d& p) const { return of.normal.dot(p) - of.offset; }

  std::array<int, 6> extremes() const;
  bool start();
  bool set_plane(Facet& of) const;
  void assign(int point, std::span<const int> among);
  bool add(int point, int seen_from);
  void remove_visible(const Eigen::Vector3d& eye, int start);
  bool order_horizon();

  // An edge of a visible facet beyond which the facet is not visible.
  struct HorizonEdge {
    int from, to, beyond;
  };

  std::span<const Eigen::Vector3d> points_;
  double tolerance_;
  std::vector<Facet> facets_;
  std::vector<int> removed_;  // facets removed by the present point
  std::vector<HorizonEdge> horizon_;
};

}  // namespace gelenk
