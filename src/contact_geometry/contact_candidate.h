// SPDX-License-Identifier: BSD-3-Clause
// A candidate: features at which two shapes can touch, the limit of the swing of a ball joint, or friction of a joint,
// and how they are placed and move.
#pragma once

#include <Eigen/Core>

#include "math/spatial.h"
#include "shape/features.h"
#include "shape/rounded.h"

namespace gelenk {

struct ContactCandidate {
  // corner: a tip on one face of a box. swing: an axis of the tip's link within a cone that is fixed to the core's; its
  // gap is an angle, its normal the axis of the torque, and there are no shapes. friction: of a joint along several
  // velocities together; it is always closed, with a normal force that is given and has no row, and has no shapes
  // either.
  enum class Kind { tip, corner, edges, rim, swing, friction };

  Kind kind = Kind::tip;
  int core = 0, tip = 0;  // shapes of the mechanism; -1: none
  int core_link = 0, tip_link = 0;
  int pair = 0;                                   // of shapes: those of a pair follow each other
  int contact = 0;                                // of the scene
  int feature = 0;                                // of the tip
  double sign = 1;                                // -1: the shape of the tip has the first surface of the contact
  Pose3 X_LS, X_tip;                              // of the core and of the shape of the tip in their links
  RoundedBox box;                                 // the core, in S
  Eigen::Vector3d center;                         // of the tip in its link [m]
  Eigen::Vector3d way;                            // to it from the middle of all tips of its shape [m]
  double radius = 0;                              // of the tip or the rim [m]
  double crown = 0;                               // about the rim [m]
  double size = 0;                                // of the smaller shape [m]
  int face = 0;                                   // of the box: the axis of its normal, plus 3 for the negative one
  SolidEdge core_edge;                            // in the link of the core
  SolidEdge tip_edge;                             // in the link of the tip; of a rim, center and axis
  int placed_core_edge = 0, placed_tip_edge = 0;  // among the edges of all shapes
  Eigen::Matrix3d R_belt;                         // from the shape with the second surface to its link
  Eigen::Vector3d core_axis, tip_axis;            // of a swing: unit, in the links; of friction: core_axis, the normal
  double swing = 0;                               // rad: the largest angle between them
  int tangential = 2;                             // components of the group of tangential forces; 3: in all directions
  bool is_moment = false;                         // of friction: these are moments

  // Whether its normal force is given.
  bool is_given() const { return kind == Kind::friction; }
  bool has_shapes() const { return kind != Kind::swing && kind != Kind::friction; }
  // Whether its force is a torque, of a swing about the normal.
  bool turns() const { return kind == Kind::swing || is_moment; }
  // Whether group `group` has moments; those of a swing have no coefficients.
  bool group_turns(int group) const { return group > 0 || is_moment; }
};

// Where and how the shapes of a candidate touch or nearly do, in the root frame.
template <class T>
struct CandidateStateOf {
  Vector3<T> p, p_dot;  // m, m/s: the point of contact
  Vector3<T> n, n_dot;  // unit normal, from the core to the tip; 1/s. Of a swing it is of unit length in contact
  T gap{0}, rate{0};    // m, m/s; rad, rad/s
};
using CandidateState = CandidateStateOf<double>;

}  // namespace gelenk
