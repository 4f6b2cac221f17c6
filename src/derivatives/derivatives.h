// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of the equations of motion by coordinates, speeds and inputs. Here the kernels run on numbers that
// carry them (math/dual.h), some directions at a time: for whatever a mechanism has. recursive_slopes.h is faster.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "derivatives/extended.h"
#include "math/dual.h"

namespace gelenk {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Of the residuals
//   r = M(q) vdot + h(q, v) + J(q)^T lambda - tau(q, v, u)     (nv)
//   c = J(q) vdot - gamma(q, v)                                (rows)
// with vdot and lambda held, of Phi and J v, and of qdot = N(q) v. By q: by its nq numbers, each free (a quaternion's
// length too).
struct Slopes {
  // Told by who asks: whether Phi_q and rate_q are wanted, and r_u.
  bool of_rows = true, of_inputs = false;

  RowMatrix r, c;                  // nv x (nq + nv), rows x (nq + nv): by q, then by v
  RowMatrix r_u;                   // nv x inputs of the scene
  RowMatrix Phi_q, rate_q;         // rows x nq: of Phi and of J v; by v the latter is J
  Eigen::MatrixXd qdot_q, qdot_v;  // nq x nq, nq x nv

  auto r_q() { return r.leftCols(qdot_q.rows()); }
  auto r_v() { return r.rightCols(r.rows()); }
  auto c_q() { return c.leftCols(qdot_q.rows()); }
  auto c_v() { return c.rightCols(r.rows()); }

  // All zero, of these sizes.
  void clear(int nq, int nv, int rows, int inputs);
};

// A point at which to differentiate; u: all inputs of the scene. cut_reference: angles of cut joints as counted.
struct Point {
  const double* q;
  const double* v;
  const double* u;
  const double* vdot;
  const double* lambda;
  const double* cut_reference;
  const double* targets;           // of the coordinate rows (dynamics.h)
  const int* cut_sides = nullptr;  // on which what acts along cut joints is held, or null; by recursion only
};

// Works in memory of its own; allocates when made only.
class Differentiator {
 public:
  // inputs: number of the scene's inputs.
  Differentiator(const Mechanism& mechanism, const Loads& loads, int inputs);

  void operator()(const Point& at, Slopes& out);

 private:
  void run(const Point& at);
  template <class Take>
  void sweep(const Point& at, std::vector<Dual>& in, Take take);

  std::unique_ptr<Extended<Dual>> equations_;
  std::vector<Dual> q_, v_, u_, vdot_, lambda_, targets_;
};

}  // namespace gelenk
