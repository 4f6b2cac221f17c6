// SPDX-License-Identifier: BSD-3-Clause
// Equations of motion of a mechanism in joint coordinates:
//
//   M(q) vdot + h(q, v) + J(q)^T lambda = tau(q, v, u)      Phi(q, t) = 0,   J v = b(t),   J vdot = gamma(q, v, t)
//
// One object per instance and thread. After construction nothing here allocates memory. Arrays: q (nq), v, vdot,
// tau (nv), lambda and rows (rows), u (inputs), in the mechanism's own signs and order.
#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "derivatives/jacobians.h"
#include "kinematics/kinematics.h"
#include "kinematics/model.h"
#include "kinematics/readings.h"

namespace gelenk {

// Some body moves without inertia: M cannot be factorized. The message names the link.
class SingularMass : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What outputs are read from, where the equations stand.
class StateReadings : public Readings<double> {
 public:
  // Poses of all links in the root frame, after set_position.
  virtual void set_root_poses() = 0;
  // Makes tree_reaction() and cut_reaction() tell the wrenches of these multipliers alone, at rest and without loads.
  virtual void set_multipliers(const double* lambda) = 0;
};

// What acts along joints and has branches (element/coordinate_force.h), in the tree and where loops are cut.
class Branching {
 public:
  virtual ~Branching() = default;

  virtual int count() const = 0;
  // Of each, where the equations stand: the branch on which it is.
  virtual void sides(int* sides) const = 0;
  // Likewise two numbers that vanish where that changes, with their rates.
  virtual void indicators(double* g, double* gdot) const = 0;
  // From now on the equations take them on these branches (read then), and differentiate() too; null: on those of the
  // state.
  virtual void hold(const int* sides) = 0;
};

class Dynamics : public Kinematics {
 public:
  // --- in this order; each uses what the ones before, and set_position and set_velocity, have left ---
  // M, J and their factors at a position. Throws SingularMass.
  virtual void factorize() = 0;
  // Whether M alone is positive definite at that position, beyond rounding. Allocates; the factors are lost.
  virtual bool mass_is_definite() = 0;
  // Solves for vdot under the inputs u. expected: vdot to be followed along weak pivots, or null: none is weak.
  virtual void solve(const double* u, double* vdot, const double* extrapolated = nullptr) = 0;
  // Pivots of the rows near or below this ratio to the largest are weak (row_factor.h); 0: none.
  virtual void set_singular_threshold(double ratio) = 0;
  // From now on solve() takes J vdot = gamma + shift (rows numbers, read then; nullptr: none), until set again.
  virtual void set_constraint_bias(const double* shift) = 0;
  // Instead of factorize() and solve(), after set_velocity: M (nv x nv, full), f = tau - h, and J. The factors are
  // lost.
  virtual void assemble(const double* u, double* M, double* f) = 0;
  // lambda and body accelerations for the vdot found, after solve.
  virtual void set_acceleration(const double* vdot) = 0;

  // Exact derivatives of the residuals at the state of the last solve(), with its vdot and lambda; or those of
  // assemble(), with any vdot and lambda. u: `inputs` numbers. Allocates when first called.
  // by_duals: as for mechanisms that recursion does not cover.
  virtual void differentiate(const double* u, int inputs, const double* vdot, Jacobians& out,
                             const double* lambda = nullptr, bool by_duals = false) = 0;
  // [M J^T; J 0] [x; l] = [r; c] with the last factors; r is overwritten by x. Where the last solve() followed
  // something expected, x = 0 is followed there. l: of minimum norm, or null.
  virtual void solve_linear(double* r, const double* c, double* l = nullptr) const = 0;
  // The same for many right sides at a time, without l: r (nv x columns) and c (rows x columns) row by row.
  virtual void solve_linear_columns(double* r, const double* c, int columns) const = 0;
  // dv <- the smallest displacement (mass metric, last factors) that takes the residual of the rows away.
  virtual void min_norm_displacement(const double* residual, double* dv) const = 0;

  virtual const std::vector<double>& lambda() const = 0;  // after set_acceleration
  virtual Eigen::Map<const RowMatrix> J() const = 0;      // rows x nv, after factorize or assemble
  virtual int rank() const = 0;
  virtual double pivot_ratio() const = 0;  // the smallest pivot over the largest (row_factor.h); 0: rank is lost
  // Rows beyond this rank are taken to repeat others; rows() at first.
  virtual void set_max_rank(int rank) = 0;

  virtual StateReadings& readings() = 0;
  virtual const StateReadings& readings() const = 0;
  virtual Branching& branching() = 0;

  virtual long evaluations() const = 0;  // calls of solve and assemble
};

// everything: each solve() also computes what only outputs need, read or not (to show what leaving it out gains).
std::unique_ptr<Dynamics> make_dynamics(const Mechanism& mechanism, const Loads& loads, bool everything = false);

}  // namespace gelenk
