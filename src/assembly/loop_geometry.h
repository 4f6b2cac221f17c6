// SPDX-License-Identifier: BSD-3-Clause
// Loop equations as functions of the coordinates and of the positions of the joint frames in their links: Phi(q, d) and
// its derivatives, J by displacements along the velocities and A by small twists of the frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// For spatial mechanisms. Contacts and time-dependent constraint equations are left out.
class LoopGeometry {
 public:
  // One half of a joint in a loop, fixed in a link.
  struct Frame {
    int scene_joint = -1;
    bool child = false;     // the half is in the scene joint's child body
    bool has_axis = false;  // the joint has a single axis, its z axis
    int link = 0;
    Pose3 X_given;  // in the link, as given in the scene
    Pose3 X;        // in the link, adjusted
  };

  struct Equations {
    Eigen::VectorXd Phi;  // m, rad
    Eigen::MatrixXd J;    // rows x nv
    Eigen::MatrixXd A;    // rows x 6 frames: turn [rad] and shift [m] of each frame, along its own axes
  };

  explicit LoopGeometry(const Mechanism& mechanism);

  const std::vector<Frame>& frames() const { return frames_; }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index velocities() const { return mechanism_.nv; }
  // m: the largest distance of a joint frame from its link frame, at least 1.
  double size() const;

  Equations equations(const std::vector<double>& q) const;
  // q displaced along the velocities, as by Dynamics::displace.
  std::vector<double> displaced(std::vector<double> q, const Eigen::VectorXd& dv) const;

  // Moves the frames by 6 numbers each, turn [rad] and shift [m] along the frame's axes: X <- X exp(d), to first order
  // in the shift.
  void move(const Eigen::VectorXd& d);
  // Turns a frame's axes by R, written in its link.
  void turn(std::size_t frame, const Eigen::Matrix3d& R) { frames_[frame].X.R = R * frames_[frame].X.R; }

 private:
  struct Ends {  // frame indices: of a tree joint in the inner and the outer link; of a cut joint in links a and b
    int inner = -1, outer = -1;
  };

  int add_frame(int scene_joint, bool child, bool has_axis, int link, const Pose3& X);
  std::vector<Pose3> link_poses(const std::vector<double>& q) const;
  void add_motion_columns(const std::vector<double>& q, const std::vector<Pose3>& X_0L, const Cut& cut,
                          const Spatial::Force* wrenches, Eigen::Index first, int count, Equations& out) const;
  void add_twist_columns(const Pose3& X, double sign, const Spatial::Force* wrenches, Eigen::Index first, int count,
                         int frame, Eigen::MatrixXd& A) const;

  const Mechanism& mechanism_;
  std::vector<Frame> frames_;
  std::vector<Ends> of_links_, of_cuts_;
  std::vector<const CoordinateRow*> coordinate_rows_;
  Eigen::Index rows_ = 0;
};

}  // namespace gelenk
