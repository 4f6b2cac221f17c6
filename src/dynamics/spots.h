// SPDX-License-Identifier: BSD-3-Clause
// The spots at which shapes of a mechanism can touch, each with a gap that is a smooth function of time: the tips of
// one shape on the core of another (shape/rounded.h).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/dynamics.h"
#include "shape/rounded.h"

namespace gelenk {

struct Spot {
  int core = 0, tip = 0;  // shapes of the mechanism
  int core_link = 0, tip_link = 0;
  int contact = 0;         // of the scene
  int feature = 0;         // of the tip
  double sign = 1;         // -1: the shape of the tip has the first surface of the contact
  Pose3 X_LS;              // of the core in its link
  RoundedBox box;          // the core, in S
  Eigen::Vector3d center;  // of the tip in its link [m]
  double radius = 0;       // of the tip [m]
  double size = 0;         // of the smaller shape [m]
  Eigen::Matrix3d R_belt;  // from the shape with the second surface to its link
};

// Where and how the shapes of a spot touch or nearly do, in the root frame.
struct SpotState {
  Eigen::Vector3d p, p_dot;  // m, m/s: the point of contact
  Eigen::Vector3d n, n_dot;  // unit normal, from the core to the tip; 1/s
  double gap = 0, rate = 0;  // m, m/s
};

// Motion of the tip's link relative to the core's, about the origin of the root frame; the acceleration is that without
// generalized accelerations.
struct RelativeMotion {
  Spatial::Motion V, A;

  Eigen::Vector3d velocity(const Eigen::Vector3d& p) const { return V.v + V.w.cross(p); }
  // The rate of velocity(p), where p moves.
  Eigen::Vector3d acceleration(const Eigen::Vector3d& p, const Eigen::Vector3d& p_dot) const {
    return A.v + A.w.cross(p) + V.w.cross(p_dot);
  }
};

class Spots {
 public:
  explicit Spots(const Mechanism& mechanism);

  int count() const { return static_cast<int>(spots_.size()); }
  const Spot& operator[](int spot) const { return spots_[static_cast<std::size_t>(spot)]; }

  // Reads the present position of `dynamics`, and its velocity and bias accelerations.
  void read_position(Dynamics& dynamics);
  void read_motion(Dynamics& dynamics);

  // After read_position().
  double gap(int spot) const;
  // After read_motion().
  SpotState state(int spot) const;
  RelativeMotion motion(int spot) const;
  // A vector fixed to the link of the second surface, and its rate, both in the root frame.
  Eigen::Vector3d belt(int spot, const Eigen::Vector3d& velocity, Eigen::Vector3d& rate) const;

 private:
  struct Line {  // from the nearest point of the core's box to the center of the tip, in S
    Eigen::Vector3d x, normal;
    Eigen::Vector3d free;  // 1 where the nearest point does not follow the center, else 0
    double distance = 0;
  };
  // Spots of the tips of one shape on the core of another; both: numbers of shapes.
  void add_pair(const Mechanism& mechanism, int contact, int tip, int core);
  Line line(const Spot& spot) const;
  const Pose3& pose(int link) const { return poses_[static_cast<std::size_t>(link)]; }

  std::vector<Spot> spots_;
  std::vector<int> links_;              // with shapes
  std::vector<Pose3> poses_;            // by link, in the root frame
  std::vector<Spatial::Motion> V_, A_;  // by link, in and about the root frame
};

}  // namespace gelenk
