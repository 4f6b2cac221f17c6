// SPDX-License-Identifier: BSD-3-Clause
// Rows of the relative velocities at contacts, and of single coordinates, along which impulses act between two states
// of the mechanism. With the factors M = L^T L and the constraint equations J,
//   G = Y^T P Y,   Y = L^-T R^T,
// R the rows and P the projection onto the velocities that the constraints permit: the Delassus operator of the
// constrained mechanism. Loops are eliminated exactly; redundant constraint equations do not matter.
#pragma once

#include <Eigen/Core>
#include <span>

#include "math/spatial.h"

namespace gelenk {

// Row r has the entries first[r] to first[r + 1], in ascending columns.
struct WhitenedRows {
  int columns = 0;
  std::span<const int> first;
  std::span<const int> column;
  std::span<const double> value;
};

class ContactRows {
 public:
  virtual ~ContactRows() = default;

  // Allocates what this number of rows needs, so that the functions below do not allocate (of large mechanisms,
  // rarely).
  virtual void reserve(int rows) = 0;

  // --- after Dynamics::factorize() and set_root_poses(), at one position ---
  // Removes all rows.
  virtual void clear() = 0;
  // Adds the row of the velocity of link b relative to link a at the point p along d [m/s] or, if it turns, of the
  // relative angular velocity about d [rad/s]. p, d: in the root frame.
  virtual void add(int link_a, int link_b, const Eigen::Vector3d& p, const Eigen::Vector3d& d, bool turns) = 0;
  // out <- that row, as nv numbers, without adding it.
  virtual void row(int link_a, int link_b, const Eigen::Vector3d& p, const Eigen::Vector3d& d, bool turns,
                   double* out) const = 0;
  // Adds the row of the speed of the coordinate of a lock (switching_forces.h), times a factor.
  virtual void add_lock(int lock, double factor) = 0;
  virtual int count() const = 0;

  // out <- R v, by row; v: generalized velocities.
  virtual void speeds(const double* v, double* out) const = 0;
  // out <- G x.
  virtual void apply(const double* x, double* out) const = 0;
  // Y^T by rows, so that G = Y^T Y; with loops nothing, as P is not sparse. Valid until rows change.
  virtual WhitenedRows whitened() const = 0;
  // The rows and columns first to first + size of G, row by row. Without loops; with loops the same without P, which is
  // larger.
  virtual void block(int first, int size, double* out) const = 0;
  // out <- out + factor R^T x for the rows from `first` on; out: generalized forces.
  virtual void add_generalized(int first, const double* x, double factor, double* out) const = 0;
  // v <- v + M^-1 P' R^T x: the effect of the impulses x.
  virtual void strike(const double* x, double* v) const = 0;

  // Makes Dynamics::solve() apply these wrenches to the links, besides the loads, and show them in reactions. By link,
  // about the origin and along the axes of the root frame, in spatial mechanisms only. along: generalized forces, by
  // velocity. Read at each evaluation; null: none.
  virtual void apply_forces(const Spatial::Force* wrenches, const double* along) = 0;
};

}  // namespace gelenk
