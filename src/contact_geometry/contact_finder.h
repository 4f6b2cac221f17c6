// SPDX-License-Identifier: BSD-3-Clause
// The points at which shapes of a mechanism touch or nearly do.
#pragma once

#include <Eigen/Core>
#include <array>
#include <tuple>
#include <vector>

#include "collision/contacts.h"
#include "collision/sweep_and_prune.h"
#include "dynamics/dynamics.h"
#include "mechanism/mechanism.h"

namespace gelenk {

// A point of contact of two shapes of Mechanism::shapes; a has the first surface of the contact of the scene. Or the
// limit of a swing (Mechanism::swings), numbered after the shapes, where axes at an angle play the part of shapes at a
// distance; or friction (Mechanism::frictions), numbered after these.
struct NearPoint {
  int a = 0, b = 0;
  int link_a = 0, link_b = 0;
  bool turns = false;                                 // its force is a torque, of a swing about the normal
  int given = 0;                                      // of friction: number of its components; it has no normal row
  int contact = 0;                                    // of the scene
  Eigen::Vector3d p = Eigen::Vector3d::Zero();        // m, in the root frame
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, from a to b, in the root frame
  double gap = 0;                                     // m, rad
  int feature = 0;                                    // number of the touching features; the same while they touch

  // Identifies the point from one step to the next.
  std::tuple<int, int, int> key() const { return {a, b, feature}; }
};

class ContactFinder {
 public:
  // contacts: number of contacts of the scene.
  ContactFinder(const Mechanism& mechanism, std::size_t contacts);

  // Calls visit(contact) for each pair of shapes that can touch, each swing and each friction, until it returns false.
  template <class Visit>
  void each_pair(const Visit& visit) const {
    const int n = static_cast<int>(mechanism_.shapes.size());
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        if (const int contact = contact_of(a, b); contact >= 0 && !visit(contact)) return;
      }
    }
    for (const Swing& swing : mechanism_.swings) {
      if (!visit(swing.contact)) return;
    }
    for (const LinkFriction& friction : mechanism_.frictions) {
      if (!visit(friction.contact)) return;
    }
  }
  // Allocates what find() needs for this number of points.
  void reserve(std::size_t points) { points_.reserve(points); }

  // All points with a gap of at most the reach of both shapes, ordered by their keys. readings: of dynamics, after
  // set_root_poses() and set_velocity(). A shape reaches as far as it moves in `time` [s] with `speed` [m/s] more than
  // its present speed, and `distance` [m] further.
  const std::vector<NearPoint>& find(const Readings<double>& readings, double time, double speed, double distance);
  // The smallest gap of each contact of the scene; infinite if it has no pair of shapes.
  const std::vector<double>& smallest_gaps(const Readings<double>& readings);

  const Pose3& pose(int shape) const { return poses_[static_cast<std::size_t>(shape)]; }
  // The most by which a step may move a point to remove its penetration: the size of a shape [m], or an angle [rad].
  double size(int shape) const;

 private:
  void place(const Readings<double>& readings);
  // Points of two shapes, of which `a` gets the first surface of their contact.
  struct Found {
    int count = 0;
    int contact = -1;
    std::array<ContactPoint, max_contact_points> points{};
  };
  Found points_of(int& a, int& b) const;
  // The contact between two shapes; -1: they cannot touch.
  int contact_of(int a, int b) const;
  NearPoint swing_point(const Readings<double>& readings, std::size_t i) const;
  NearPoint friction_point(const Readings<double>& readings, std::size_t i) const;

  const Mechanism& mechanism_;
  std::vector<Pose3> poses_;   // X_0S
  std::vector<double> reach_;  // m
  std::vector<Aabb> boxes_;
  std::vector<double> gaps_;
  std::vector<Pose3> gap_poses_;  // those of gaps_
  bool has_gaps_ = false;
  SweepAndPrune broad_phase_;
  std::vector<NearPoint> points_;
};

// Gaps up to this are contact [natural units of length]: rounding of positions, far below what can be measured.
inline constexpr double touch_tolerance = 1e-10;

// The first contact of the scene that is closed at the present position of `dynamics`, after set_root_poses(); -1:
// none.
int closed_contact(const Mechanism& mechanism, const Readings<double>& readings, std::size_t contacts);

// Axes with the first along n; a continuous function of n nearly everywhere.
Eigen::Matrix3d contact_axes(const Eigen::Vector3d& n);

}  // namespace gelenk
