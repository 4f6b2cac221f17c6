// SPDX-License-Identifier: BSD-3-Clause
// The Jacobians of the equations of motion, and the point at which they are taken. Two methods compute them:
// recursion along the tree (recursive.h, fast) and forward-mode automatic differentiation (forward_ad.h, for all kinds
// of elements).
#pragma once

#include <Eigen/Core>

namespace gelenk {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Partial derivatives of the residuals
//   r = M(q) vdot + h(q, v) + J(q)^T lambda - tau(q, v, u)     (nv)
//   c = J(q) vdot - gamma(q, v)                                (rows)
// at constant vdot and lambda, of Phi and J v, and of qdot = N(q) v. Derivatives in q are taken in its nq numbers, each
// of them independent (the norm of a quaternion, too).
struct Jacobians {
  // Set by the caller: whether Phi_q and rate_q are computed, and r_u.
  bool of_rows = true, of_inputs = false;

  RowMatrix r, c;  // nv x (nq + nv), rows x (nq + nv): with respect to q, then to v
  RowMatrix r_u;   // nv x signals, or more; also set if there are element states
  // Of the rates of the element states: states x (nq + nv), with respect to q, then to v, and states x signals.
  RowMatrix rates, rates_u;
  RowMatrix Phi_q, rate_q;         // rows x nq: of Phi and of J v; the derivative of J v in v is J
  Eigen::MatrixXd qdot_q, qdot_v;  // nq x nq, nq x nv

  auto r_q() { return r.leftCols(qdot_q.rows()); }
  auto r_v() { return r.rightCols(r.rows()); }
  auto c_q() { return c.leftCols(qdot_q.rows()); }
  auto c_v() { return c.rightCols(r.rows()); }

  // Writes the derivatives of the rates of the element states with respect to (q, v) and to these states, of which the
  // signals begin at `first`.
  template <class Out>
  void put_rates(int first, Out&& out) const {
    if (rates.rows() == 0) return;
    out.leftCols(rates.cols()) = rates;
    out.middleCols(rates.cols(), rates.rows()) = rates_u.middleCols(first, rates.rows());
  }

  // Resizes all matrices and sets them to zero; those of element states have `states` rows.
  void clear(int nq, int nv, int rows, int inputs, int states = 0);
};

// The point at which Jacobians are taken.
struct LinearizationPoint {
  const double* q;
  const double* v;
  const double* u;  // all signals (kinematics/loads.h)
  const double* vdot;
  const double* lambda;
  const double* cut_reference;     // angles of cut joints, full revolutions included
  const double* targets;           // of the coordinate constraints (dynamics.h)
  const int* cut_sides = nullptr;  // the branches that forces along cut joints are held on, or null; recursion only
};

}  // namespace gelenk
