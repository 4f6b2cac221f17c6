// SPDX-License-Identifier: BSD-3-Clause
// The proximal point method with a semismooth Newton method in the space of velocities: a semismooth Newton augmented
// Lagrangian method (Rockafellar 1976; Li, Sun & Toh 2018), for large problems with a sparse root W of G.
//
// With the impulses x_k of the last step and De Saxce's shift s held constant, the proximal problem
//   min 1/2 x^T G x + (b + s)^T x + rho/2 |x - x_k|^2 over K
// is solved by x = P_K(z(w)), z = x_k - (W^T w + b + s) / rho, where the velocities w = W x are the minimum of
//   psi(w) = 1/2 |w|^2 + rho (z . P_K(z) - 1/2 |P_K(z)|^2),
// which is smooth, strongly convex and unconstrained: Newton's method with line search converges from everywhere, also
// where impulses are redundant. Its matrix has the rows of the velocities and is as sparse as the graph of contacts.
#pragma once

#include "complementarity/velocity_hessian.h"
#include "linear/anderson.h"

namespace gelenk {

class AugmentedLagrangian {
 public:
  // Of the proximal term, relative to the mean diagonal of G.
  static constexpr double largest_weight = 1e-3;

  // Up to max_outer proximal steps. hessian: started with the problem. first_weight: of the proximal term, up to
  // largest_weight.
  void run(ConeIteration& at, VelocityHessian& hessian, int max_outer, double first_weight);

 private:
  void reserve(Eigen::Index n);
  void center_at_iterate(ConeIteration& at);
  void set_lift(ConeIteration& at, double* out) const;
  // Returns whether it was solved, to a fraction of the error that the next one will change.
  bool proximal_step(ConeIteration& at);
  void evaluate(ConeIteration& at);
  double line_search(ConeIteration& at);
  void linearize(ConeIteration& at);
  double derivative(ConeIteration& at, double length);

  VelocityHessian* hessian_ = nullptr;
  ConeMemory memory_;
  double rho_ = 0, prox_error_ = 0, shift_error_ = 0;
  double *center_ = nullptr, *shift_ = nullptr, *t_ = nullptr, *dt_ = nullptr;
  double *z_ = nullptr, *p_ = nullptr, *trial_ = nullptr, *lift_ = nullptr;
  AndersonAcceleration acceleration_;
  Eigen::VectorXd y_, image_;
  double last_error_ = 0;
  std::vector<ProjectionModes> modes_;
  std::vector<ModeWeights> weights_;
  Eigen::VectorXd w_, dw_, g_;
};

}  // namespace gelenk
