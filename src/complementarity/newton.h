// SPDX-License-Identifier: BSD-3-Clause
// The semismooth Newton method on the natural map F(x) = x - P_K(x - u - s(u)), u = G x + b (Qi & Sun 1993; Alart &
// Curnier 1991), regularized where G is singular.
//
// With the projection's Jacobian J = Q diag(lambda) Q^T (projection.h; Q: the modes with lambda > 0) the step
// dx = Q y + dx_0 satisfies
//   dx_0 = -(1 - Q Q^T) F,
//   (Q^T (1 + S) G Q + diag(1 / lambda - 1) + eps) y = -diag(1 / lambda) Q^T F - Q^T (1 + S) G dx_0,   S = ds/du:
// only what is in contact takes part, a sliding contact with two unknowns of three. In a convex problem S is 0 and the
// matrix symmetric and positive definite. eps is the proximal-point regularization: redundant impulses then stay where
// they are.
#pragma once

#include <array>
#include <vector>

#include "complementarity/iteration.h"
#include "complementarity/projection.h"
#include "complementarity/velocity_hessian.h"

namespace gelenk {

class SemismoothNewton {
 public:
  // Allocates what a problem of this size needs. hessian: solves the linear systems of problems with a sparse root, and
  // is started with the problem; null: a dense matrix does.
  void reserve(Eigen::Index n, std::size_t cones, VelocityHessian* hessian = nullptr);
  // Up to max_steps steps. Returns early if steps no longer reduce the natural map.
  void run(ConeIteration& at, int max_steps);
  // The same for the convex problem with a constant shift of the velocities (at.size() numbers), until that is solved
  // to a fraction.
  void run_with(const double* shift, ConeIteration& at, int max_steps);

 private:
  void iterate(ConeIteration& at, int max_steps, double fraction);
  double natural_map(ConeIteration& at, const double* x, const double* u, double* F) const;
  void linearize(ConeIteration& at);
  void move_by_modes(ConeIteration& at, const Cone& cone, const ProjectionModes& modes, Eigen::Index from);
  void project_on_modes(const Cone& cone, const ProjectionModes& modes, const double* velocity, double* out) const;
  void assemble(ConeIteration& at, double eps);
  void right_side(ConeIteration& at);
  void solve_reduced(bool general, double eps);
  bool solve_sparse(ConeIteration& at, double eps);
  bool slides(const Cone& cone) const;
  bool something_slides(std::span<const Cone> cones) const;
  void set_weights(ConeIteration& at, double eps);
  void solve_in_velocities(ConeIteration& at);
  double set_left(ConeIteration& at);
  void expand(ConeIteration& at, const double* y, double* x) const;
  bool find_step(ConeIteration& at, double eps);
  bool take_step(ConeIteration& at);

  bool exact_ = false;
  const double* shift_ = nullptr;
  VelocityHessian* hessian_ = nullptr;
  std::vector<ModeWeights> weights_;
  std::vector<double> lifted_, y_, left_, right_side_;
  Eigen::VectorXd w_, right_;
  ConeMemory memory_;
  std::vector<ProjectionModes> modes_;
  std::vector<int> first_;  // row of each cone's first mode
  std::vector<int> pivots_;
  Eigen::Index rows_ = 0;  // of the reduced system
  // Squared norms of F at the last iterates. A step may exceed all but the largest: monotone steps stall where impulses
  // are redundant (nonmonotone line search: Grippo, Lampariello & Lucidi 1986).
  std::array<double, 6> merits_{};
  double *z_ = nullptr, *F_ = nullptr, *sigma_ = nullptr, *dx_ = nullptr, *Gdx_ = nullptr;
  double *trial_x_ = nullptr, *trial_u_ = nullptr, *trial_F_ = nullptr, *rhs_ = nullptr, *A_ = nullptr, *T_ = nullptr;
};

}  // namespace gelenk
