// SPDX-License-Identifier: BSD-3-Clause
// Positions and velocities of a mechanism in joint coordinates, and its constraint equations there:
//
//   Phi(q, t) = 0,   J(q) v = b(t),   J vdot = gamma(q, v, t)
//
// Arrays: q (nq), v (nv), constraint equations (rows), in the mechanism's signs and order.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "linear/sparse_rows.h"
#include "math/spatial.h"

namespace gelenk {

class Kinematics {
 public:
  virtual ~Kinematics() = default;

  // Sets s, ds/dt and d2s/dt2 of each coordinate constraint, effective from the next set_position().
  virtual void set_targets(const double* targets) = 0;
  virtual const std::vector<double>& targets() const = 0;
  // Computes poses of links in their parents, and the position errors Phi.
  virtual void set_position(const double* q) = 0;
  // Computes velocities, J v - b (row_rates) and gamma, at that position.
  virtual void set_velocity(const double* v) = 0;
  // The coordinates and velocities alone, for the laws of forces along tree joints; nothing follows from them before
  // set_position().
  virtual void set_coordinates(const double* q, const double* v) = 0;

  virtual const std::vector<double>& Phi() const = 0;        // after set_position
  virtual bool row_is_angle(int row) const = 0;              // Phi of this equation is in rad, not m
  virtual Eigen::SparseMatrix<double> sparse_J() = 0;        // after set_position; allocates
  virtual const SparseRows& rows_of_J() = 0;                 // after set_position
  virtual const std::vector<double>& row_rates() const = 0;  // after set_velocity
  virtual const std::vector<double>& gamma() const = 0;      // after set_velocity

  // Coordinates of a cut joint: angles in [-pi, pi]; quaternions with the sign nearest to the value of `q` on entry.
  virtual void cut_coordinates(int cut, double* q) const = 0;
  // Sets the coordinates of cut joints with full revolutions (cut_nq numbers), for the forces along them.
  virtual void set_cut_reference(const double* q) = 0;
  // Speeds of a cut joint per velocity of the links of path_a, then of path_b (Cut), each cut.nv numbers; after
  // set_position.
  virtual void cut_speed_columns(int cut, double* columns) const = 0;
  virtual Pose3 cut_pose(int cut) const = 0;  // X_FM

  // qdot <- N(q) v.
  virtual void qdot_from_v(const double* q, const double* v, double* qdot) const = 0;
  // q <- q displaced by the small dv (velocities times a time), with quaternions normalized.
  virtual void displace(double* q, const double* dv) const = 0;
  // Normalizes the quaternions in q.
  virtual void normalize(double* q) const = 0;
};

}  // namespace gelenk
