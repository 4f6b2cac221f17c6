// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/branch_acceleration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "decomposition/dense.h"
#include "decomposition/singular_values.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double weak_row_ratio = 1e-3;       // singular values below, relative to J's largest: lost equations
constexpr double difference_distance = 1e-4;  // rad or m: of the fastest coordinate, to each end of a difference

}  // namespace

// Time derivative of l^T (J vdot - gamma) along the motion with these accelerations, by central differences with an
// error of the order of difference_distance^2.
VectorXd BranchAcceleration::excess_rate(const VectorXd& vdot) {
  const double h = difference_distance / v_.lpNorm<Eigen::Infinity>();  // s
  VectorXd ends[2];
  for (const int side : {0, 1}) {
    const double t = side == 0 ? -h : h;
    std::vector<double> q = q_;
    const VectorXd dv = t * v_ + t * t / 2 * vdot;
    const VectorXd v = v_ + t * vdot;
    dynamics_.displace(q.data(), dv.data());
    dynamics_.set_position(q.data());
    dynamics_.factorize();
    dynamics_.set_velocity(v.data());
    const VectorXd gamma = Eigen::Map<const VectorXd>(dynamics_.gamma().data(), mechanism_.rows);
    ends[side] = l_.transpose() * (dynamics_.J() * vdot - gamma);
  }
  return (ends[1] - ends[0]) / (2 * h);
}

bool BranchAcceleration::find(const double* q, const double* v, const double* u, double* vdot) {
  const Index n = mechanism_.nv;
  const Index rows = mechanism_.rows;
  q_.assign(q, q + mechanism_.nq);
  v_ = Eigen::Map<const VectorXd>(v, n);
  const double speed = n == 0 ? 0 : v_.lpNorm<Eigen::Infinity>();
  if (!(speed > 0)) return false;
  dynamics_.set_position(q);
  dynamics_.set_velocity(v);
  MatrixXd M(n, n);
  VectorXd f(n);
  dynamics_.assemble(u, M.data(), f.data());
  const MatrixXd J = dynamics_.J();
  const VectorXd gamma = Eigen::Map<const VectorXd>(dynamics_.gamma().data(), rows);
  l_ = weak_rows(J, weak_row_ratio);
  if (l_.cols() == 0) return false;
  // The remaining equations, and the rates of the lost ones, which are linear in vdot up to the error of the
  // differences.
  const VectorXd at_zero = excess_rate(VectorXd::Zero(n));
  MatrixXd A(rows + l_.cols(), n);
  VectorXd c(rows + l_.cols());
  A.topRows(rows) = J - l_ * (l_.transpose() * J);
  c.head(rows) = gamma - l_ * (l_.transpose() * gamma);
  for (Index k = 0; k < n; ++k) {
    const VectorXd e = speed * VectorXd::Unit(n, k);
    A.col(k).tail(l_.cols()) = (excess_rate(e) - at_zero) / (speed * speed);
  }
  c.tail(l_.cols()) = -at_zero / speed;
  // Gauss's principle in w = L vdot, M = L^T L: the w nearest to L^-T f with A L^-1 w = c.
  const Eigen::LLT<MatrixXd> cholesky(M);
  if (cholesky.info() != Eigen::Success) return false;
  const auto lower = cholesky.matrixL();  // M = lower lower^T
  const VectorXd free = lower.solve(f);
  const MatrixXd whitened = lower.solve(A.transpose()).transpose();
  const VectorXd w = free + least_norm_solution(whitened, c - whitened * free, weak_row_ratio / 10);
  const VectorXd found = lower.adjoint().solve(w);
  // Inconsistent rates: the velocities lie on no branch.
  const VectorXd left = whitened * w - c;
  if (!found.allFinite() || left.norm() > 1e-3 * (c.norm() + (whitened * free).norm())) return false;
  Eigen::Map<VectorXd>(vdot, n) = found;
  return true;
}

}  // namespace gelenk
