// SPDX-License-Identifier: BSD-3-Clause
// Equations of motion of a mechanism in joint coordinates:
//
//   M(q) vdot + h(q, v) + J(q)^T lambda = tau(q, v, u)      Phi(q, t) = 0,   J v = b(t),   J vdot = gamma(q, v, t)
//
// One object per instance and thread. No function allocates memory unless its comment says so. Arrays: q (nq), v, vdot,
// tau (nv), lambda and constraint equations (rows), u (the inputs of the scene and its clock, and the element states),
// in the mechanism's signs and order.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "derivatives/jacobians.h"
#include "dynamics/law_kinks.h"
#include "dynamics/switching_forces.h"
#include "kinematics/kinematics.h"
#include "kinematics/readings.h"

namespace gelenk {

struct Loads;
struct Mechanism;

// A body can move without inertia: M cannot be factorized. The message is the name of the link.
class SingularMass : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Quantities from which outputs are read, at the current state of the equations.
class StateReadings : public Readings<double> {
 public:
  // Computes the poses of all links in the root frame, after set_position.
  virtual void set_root_poses() = 0;
  // The acceleration of a link without generalized accelerations, in its frame, with the upward one in place of
  // gravity; after set_velocity.
  virtual Spatial::Motion link_bias_acceleration(int link) const = 0;
  // u, followed by what expressions name of the motion (kinematics/loads.h); after set_velocity.
  virtual const double* all_signals(const double* u) = 0;
  // Makes tree_reaction() and cut_reaction() return the wrenches of these multipliers alone, at rest without loads.
  virtual void set_multipliers(const double* lambda) = 0;
};

class Dynamics : public Kinematics {
 public:
  // --- after set_position and set_velocity, to be called in this order; each uses the results of the earlier ones ---
  // Computes and factorizes M and J at the position. Throws SingularMass.
  virtual void factorize() = 0;
  // The name of a link that moves without inertia at that position, beyond rounding, where constraint equations do not
  // help: M alone is not positive definite. Empty: none. Allocates; invalidates the factors.
  virtual std::string link_without_inertia() = 0;
  // Solves for vdot under the inputs u; coordinates that friction locks (switching_forces.h) have no acceleration, here
  // and in the linear solutions below. A mechanism at rest asks again and again under the same conditions: the last
  // solution is then returned. extrapolated: the vdot that replaces the constraint equations in the directions
  // of weak pivots, or null: no pivot is weak.
  virtual void solve(const double* u, double* vdot, const double* extrapolated = nullptr) = 0;
  // Pivots of the constraint Jacobian near or below this ratio to the largest are weak (row_factor.h); 0: none.
  virtual void set_singular_threshold(double ratio) = 0;
  // Changes with each solve(), but one that returned the last solution, and with what overwrites its holding forces.
  virtual long solution() const = 0;
  // Call when numbers of the loads or inertias of the mechanism have changed.
  virtual void loads_changed() = 0;
  // Makes solve() use J vdot = gamma + bias. bias: rows numbers, read at each evaluation; nullptr: none.
  virtual void set_constraint_bias(const double* bias) = 0;
  // Instead of factorize() and solve(): computes M (nv x nv, full), f = tau - h, and J. Invalidates the factors.
  virtual void assemble(const double* u, double* M, double* f) = 0;
  // Computes lambda and the accelerations of links for the vdot of the last solve().
  virtual void set_acceleration(const double* vdot) = 0;

  // Exact Jacobians of the residuals at the state of the last solve(), with its vdot and lambda; or of the last
  // assemble(), with any vdot and lambda. u: `inputs` numbers. Allocates on the first call.
  // by_duals: by forward-mode automatic differentiation instead of recursion.
  virtual void differentiate(const double* u, int inputs, const double* vdot, Jacobians& out,
                             const double* lambda = nullptr, bool by_duals = false) = 0;
  // Solves [M J^T; J 0] [x; l] = [r; c] with the last factors; overwrites r with x. If the last solve() had an
  // extrapolated vdot, x = 0 is the extrapolation here. l: of minimum norm, or null. holding: the holding forces
  // (SwitchingForces), if coordinates are locked, or null.
  virtual void solve_linear(double* r, const double* c, double* l = nullptr, double* holding = nullptr) const = 0;
  // The same without l for many right-hand sides: r (nv x columns) and c (rows x columns), stored row by row.
  virtual void solve_linear_columns(double* r, const double* c, int columns) const = 0;
  // dv <- the smallest displacement (in the mass metric, with the last factors) that cancels the residual of the
  // constraint equations to first order.
  virtual void min_norm_displacement(const double* residual, double* dv) const = 0;

  virtual const std::vector<double>& lambda() const = 0;  // after set_acceleration
  virtual Eigen::Map<const RowMatrix> J() const = 0;      // rows x nv, after factorize or assemble
  virtual int rank() const = 0;
  virtual double pivot_ratio() const = 0;  // smallest pivot over the largest (row_factor.h); 0: rank is lost
  // Treats constraint equations beyond this rank as redundant. Initially the number of equations.
  virtual void set_max_rank(int rank) = 0;

  virtual StateReadings& readings() = 0;
  virtual const StateReadings& readings() const = 0;
  virtual SwitchingForces& switching_forces() = 0;
  virtual LawKinks& kinks() = 0;  // of laws that are given as expressions

  // Calls of solve and assemble, and what has been counted as such: iterations for what contacts do at an event, where
  // they are more than usual, so that a budget of evaluations bounds the time.
  virtual long evaluations() const = 0;
  virtual void count_evaluations(long others) = 0;
};

// compute_all_outputs: each solve() also computes the quantities that only outputs need (to measure what is saved by
// computing them on demand).
std::unique_ptr<Dynamics> make_dynamics(const Mechanism& mechanism, const Loads& loads,
                                        bool compute_all_outputs = false);

}  // namespace gelenk
