// SPDX-License-Identifier: BSD-3-Clause
// Rotation of bodies that nothing but contacts and forces holds, and of bodies that turn about a fixed point, in steps
// that conserve their kinetic energy and angular momentum (Simo & Wong 1991). With the angular velocity w in the body,
// its mean wm = (w + w')/2 and the inertia J about the center of mass or the fixed point,
//
//   J (w' - w) = h (tau - k wm x J wm),    R' = R exp(h wm),    k = tan(a) / a,  a = h |wm| / 2.
//
// Without tau, R' J w' = R J w and w' J w' = w J w exactly, and rotation about a principal axis is exact, too. The
// implicit equation, in which gyroscopic forces do not converge by evaluating them again if the body turns fast, is
// solved by Newton's method for each body. Contacts see the body in the middle, R_m = R exp(h/2 w). Where they may act,
// and where J is a multiple of the unit matrix, R' = R_m exp(h/2 w'): then R' w' = R_m w', the velocity that the
// contacts have prescribed, and balls take up the angular momentum of impulses and torques exactly.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/readings.h"
#include "mechanism/mechanism.h"

namespace gelenk {

class FreeRotation {
 public:
  // Bodies of joints that share no constraint equation with others.
  explicit FreeRotation(const Mechanism& mechanism);

  // --- v0, v1, vm: generalized velocities at the start and the end of a step and their mean; readings: at the middle
  // of the step --- dq <- the displacement (Dynamics::displace) of the first half of the step.
  void set_first_half(double h, const double* v0, double* dq);
  // Says that impulses may act on the link in this step.
  void touch(int link) { is_touched_[static_cast<std::size_t>(link)] = true; }
  // dq <- that of the rest, which starts where the first half ends.
  void set_rest(double h, const double* v0, const double* v1, const Readings<double>& readings, double* dq) const;
  // Replaces the gyroscopic part of the accelerations vdot of what is not touched, which is that of vm, by the one of
  // the equation above. Returns false if a body turns by more than `most` [rad].
  bool balance(double h, const double* v0, const double* vm, double most, const Readings<double>& readings,
               double* vdot) const;

 private:
  struct Body {
    int link = 0;
    int turns = 0;                                       // index of the first of its three angular velocities
    int shifts = -1;                                     // of its three velocities along the axes of F; -1: none
    Eigen::Matrix3d J = Eigen::Matrix3d::Zero();         // kg m2
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();   // of J
    Eigen::Vector3d com = Eigen::Vector3d::Zero();       // m, if it shifts
    Eigen::Matrix3d R_F0 = Eigen::Matrix3d::Identity();  // from the root to F
    bool has_gyroscopic = false;                         // J differs from a multiple of the unit matrix
    bool is_offset = false;                              // its center of mass is not the origin

    Eigen::Matrix3d R_FM(const Readings<double>& readings) const { return R_F0 * readings.link_pose(link).R; }
    bool solve(double h, const Eigen::Vector3d& w0, const Eigen::Vector3d& other, double most,
               Eigen::Vector3d& wm) const;
  };
  // The start and the end of a step, as seen from its middle.
  struct Turns {
    Eigen::Quaterniond to_start, to_end;
  };
  bool is_touched(const Body& body) const { return is_touched_[static_cast<std::size_t>(body.link)]; }
  Turns turns_of(const Body& body, double h, const Eigen::Vector3d& w0, const Eigen::Vector3d& w1) const;

  std::vector<Body> bodies_;
  std::vector<bool> is_touched_;  // by link
};

}  // namespace gelenk
