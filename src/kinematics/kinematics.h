// SPDX-License-Identifier: BSD-3-Clause
// Positions and velocities of a mechanism in joint coordinates, and its constraint equations there:
//
//   Phi(q, t) = 0,   J(q) v = b(t),   J vdot = gamma(q, v, t)
//
// Arrays: q (nq), v (nv), rows (rows), in the mechanism's own signs and order.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "math/spatial.h"

namespace gelenk {

class Kinematics {
 public:
  virtual ~Kinematics() = default;

  // The time, for rows that change with it: of each coordinate row s, ds/dt, d2s/dt2. From the next set_position on.
  virtual void set_targets(const double* targets) = 0;
  // Poses of links in their parents and the rows' position errors Phi.
  virtual void set_position(const double* q) = 0;
  // Velocities, J v - b (row_rates) and gamma, at that position.
  virtual void set_velocity(const double* v) = 0;

  virtual const std::vector<double>& Phi() const = 0;        // after set_position
  virtual bool row_is_angle(int row) const = 0;              // its error is in rad, not m
  virtual Eigen::SparseMatrix<double> sparse_J() = 0;        // after set_position; allocates
  virtual const std::vector<double>& row_rates() const = 0;  // after set_velocity
  virtual const std::vector<double>& gamma() const = 0;      // likewise

  // Coordinates of a cut joint (angles within half a turn; quaternions near what `q` holds on entry).
  virtual void cut_coordinates(int cut, double* q) const = 0;
  // Angles of cut joints as last counted, for what acts along them; cut_nq numbers.
  virtual void set_cut_reference(const double* q) = 0;
  virtual Pose3 cut_pose(int cut) const = 0;  // X_FM

  virtual void qdot_from_v(const double* q, const double* v, double* qdot) const = 0;
  // q <- q moved by the small displacement dv (speeds times time), redundant parts renormalised.
  virtual void displace(double* q, const double* dv) const = 0;
  virtual void normalize(double* q) const = 0;
};

}  // namespace gelenk
