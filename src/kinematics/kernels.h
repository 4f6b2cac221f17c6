// SPDX-License-Identifier: BSD-3-Clause
// The recursions over links, templates on the algebra. Workspace holds their results.
#pragma once

#include <vector>

#include "kinematics/model.h"
#include "linear/sparse_factor.h"
#include "linear/sparse_rows.h"

namespace gelenk {

template <class A>
struct Workspace {
  using Pose = typename A::Pose;
  using Motion = typename A::Motion;
  using Force = typename A::Force;

  explicit Workspace(const Model<A>& model);

  // by link
  std::vector<Pose> X_PL, X_0L;
  std::vector<Motion> V;                    // of L in the world, in L
  std::vector<Motion> A_bias;               // acceleration of L for vdot = 0, with -gravity as that of the root
  std::vector<Motion> A_full;               // the same for a given vdot
  std::vector<Force> F;                     // scratch of the backward passes; after reactions(): joint wrench on L in L
  std::vector<Force> F_ext;                 // loads on L in L
  std::vector<typename A::Inertia> G_tree;  // composite inertia of L and all links outward
  // by velocity
  std::vector<Motion> S;  // columns of the joints' motion spaces, in L
  // by cut
  std::vector<Pose> X_FM;
  std::vector<Pose> X_FL;     // by link of the paths, see Model::Cut
  std::vector<Motion> V_FM;   // rows.h: angular velocity, rate of p_FM; in F
  std::vector<Motion> A_cut;  // bias of the rate of V_FM
  std::vector<Force> F_cut;   // motors, springs and stops, on M in M
  // by constraint equation
  std::vector<Row<A>> row;
  std::vector<typename A::Scalar> Phi, rate, gamma, lambda;
  std::vector<typename A::Scalar> factors;  // of the rates in coordinate constraints, by term; of relations alone
  SparseRows J;
};

namespace kernels {

// X_PL and S of all links.
template <class A>
void positions(const Model<A>& model, const typename A::Scalar* q, Workspace<A>& ws);
// X_0L of these links, which are listed after their ancestors. After positions.
template <class A>
void root_poses(const Model<A>& model, const std::vector<int>& links, Workspace<A>& ws);
// V and A_bias of all links. root_acceleration: -gravity, in the root's axes. After positions.
template <class A>
void velocities(const Model<A>& model, const typename A::Scalar* q, const typename A::Scalar* v,
                const typename A::Motion& root_acceleration, Workspace<A>& ws);
// tau <- the generalized forces for vdot = 0, minus those of the loads: h - J_ext^T F_ext. After velocities.
template <class A>
void inverse_dynamics_bias(const Model<A>& model, Workspace<A>& ws, double* tau);
// Fills in M (composite rigid bodies), which has rows as SparseFactor has them. After positions.
template <class A, class Factor>
void mass_matrix(const Model<A>& model, Workspace<A>& ws, Factor& M);

// Loops: X_FM, constraint wrenches and Phi (after positions); J (after loop_positions); V_FM, rates and gamma (after
// velocities).
template <class A>
void loop_positions(const Model<A>& model, Workspace<A>& ws);
// J: Workspace::J, or rows of another number type that are stored as these.
template <class A, class Rows>
void loop_jacobian(const Model<A>& model, const Workspace<A>& ws, Rows& J);
// Speeds of cut joint c at its coordinates q per velocity along its paths, cut.nv numbers each. After loop_positions.
template <class A>
void cut_speed_columns(const Model<A>& model, const Workspace<A>& ws, int c, const double* q, double* columns);
template <class A>
void loop_velocities(const Model<A>& model, Workspace<A>& ws);
// Acceleration residuals J vdot - gamma, for the accelerations in ws.A_full.
template <class A>
void loop_accelerations(const Model<A>& model, Workspace<A>& ws, typename A::Scalar* rows);

}  // namespace kernels
}  // namespace gelenk
