// SPDX-License-Identifier: BSD-3-Clause
// The equations of closed loops as functions of the coordinates and of where the frames of the joints sit in their
// links: Phi(q, d) and its derivatives, J by displacements along the speeds and A by small twists of the frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// Of a mechanism in space. Contacts, and rows that change with time, are left out.
class LoopGeometry {
 public:
  // One half of a joint that is part of a loop, fixed in a link.
  struct Frame {
    int scene_joint = -1;
    bool child = false;     // the half in the scene joint's child body
    bool has_axis = false;  // along its z axis, the joint's only one
    int link = 0;
    Pose3 X_given;  // in the link, as the scene has it
    Pose3 X;        // in the link, now
  };

  struct Equations {
    Eigen::VectorXd Phi;  // m, rad
    Eigen::MatrixXd J;    // rows x nv
    Eigen::MatrixXd A;    // rows x 6 frames: turn [rad] and shift [m] of each frame, along its own axes
  };

  explicit LoopGeometry(const Mechanism& mechanism);

  const std::vector<Frame>& frames() const { return frames_; }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index speeds() const { return mechanism_.nv; }
  // m: the largest distance of a frame from its link's, or 1.
  double size() const;

  Equations equations(const std::vector<double>& q) const;
  // q displaced along the speeds, as Dynamics::displace.
  std::vector<double> displaced(std::vector<double> q, const Eigen::VectorXd& dv) const;

  // Moves the frames by 6 numbers each: X <- X exp(d), to first order in the shift.
  void move(const Eigen::VectorXd& d);
  // Turns a frame's axes by R, written in its link.
  void turn(std::size_t frame, const Eigen::Matrix3d& R) { frames_[frame].X.R = R * frames_[frame].X.R; }

 private:
  struct Ends {  // of a tree joint in a loop: the halves in the inner and the outer link; of a cut those in a and b
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
