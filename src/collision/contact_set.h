// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>

#include "collision/contacts.h"

namespace gelenk {

// Collects contact points and selects those that support both bodies.
class ContactSet {
 public:
  explicit ContactSet(double margin) : margin_(margin) {}

  double margin() const { return margin_; }
  int size() const { return count_; }

  // Adds a point unless its gap exceeds the margin.
  void add(const ContactPoint& point);
  // Adds the pair of a point b of B and its projection on the surface of A along the normal, which has this distance.
  void add_above(const Eigen::Vector3d& b, const Eigen::Vector3d& normal, double gap, int feature) {
    add({b - gap / 2 * normal, normal, gap, feature});
  }
  // Adds the pair of a point a of A and its projection on the surface of B along the normal.
  void add_below(const Eigen::Vector3d& a, const Eigen::Vector3d& normal, double gap, int feature) {
    add({a + gap / 2 * normal, normal, gap, feature});
  }

  // Smallest gap of all points added; infinite if there is none.
  double least_gap() const { return least_gap_; }

  // Writes up to max_contact_points points in ascending order of features, translated by `origin`; returns their
  // number. reversed: with opposite normals.
  int write(const Eigen::Vector3d& origin, bool reversed, ContactPoint* out);

 private:
  static constexpr int capacity = 64;

  // Keeps the deepest point and up to three others that span the largest area with it.
  void reduce();
  template <class Measure>
  int best_by(double scale, const std::array<int, max_contact_points>& chosen, int n, const Measure& measure) const;

  double margin_;
  double least_gap_ = std::numeric_limits<double>::infinity();
  int count_ = 0;
  std::array<ContactPoint, capacity> points_;
};

}  // namespace gelenk
