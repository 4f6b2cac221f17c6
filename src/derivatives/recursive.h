// SPDX-License-Identifier: BSD-3-Clause
// The Jacobians of jacobians.h by recursion along the tree: a displacement along one velocity moves all outward links
// as one body, with their composite inertia and force, so that each entry of r costs a few scalar products (Carpentier
// & Mansard 2018; Singh, Russell & Wensing 2022). The same holds for the constraint equations of loops. The derivation
// is in docs/methods.md.
//
// All vectors are written in the root's axes, about a point on the first link, so that a vehicle far from the root
// loses no digits. Let S_k be the motion caused by velocity k of link i. A displacement along k moves all outward links
// by S_k and, in addition, changes velocities by P_k and accelerations by P_k x V + Q_k; velocity k itself changes
// velocities by S_k and accelerations by S_k x V + R_k. With p the parent of link i,
//   P_k = V_p x S_k + e_k,   Q_k = A_p x S_k + V_p x P_k + V_i x e_k + E_k,   R_k = V_p x S_k + V_i x S_k + b_k,
// where e, E, b are zero if S is constant in M; otherwise they are the derivatives, as seen from M, of S v and of
// S vdot + Sdot v with respect to the displacement, and of Sdot v with respect to the velocity.
#pragma once

#include <vector>

#include "derivatives/coriolis.h"
#include "derivatives/jacobians.h"
#include "kinematics/kernels.h"
#include "kinematics/loads.h"
#include "kinematics/motion_columns.h"
#include "math/dual.h"

namespace gelenk {

struct PortJacobians;  // element/forces/force.h

template <class A>
class RecursiveJacobians {
 public:
  // model, ws and loads must outlive it. ws: poses, motion spaces and constraint wrenches of the position.
  RecursiveJacobians(const Model<A>& model, const Workspace<A>& ws, const Loads& loads);

  // Overwrites `out`, according to its flags of_rows and of_inputs. inputs: number of the scene's inputs. Allocates on
  // the first call, and if `out` has other sizes.
  void operator()(const LinearizationPoint& at, int inputs, Jacobians& out);

 private:
  using Motion = typename A::Motion;
  using Force = typename A::Force;
  using Pose = typename A::Pose;
  using DualAlgebra = std::conditional_t<A::planar, PlanarAlgebra<Dual>, SpatialAlgebra<Dual>>;

  // The state of a link in the root's axes; after backward_pass() G, B, f and f_interaction include all outward links.
  struct Body {
    Pose X;
    Motion V, acc;
    typename A::Inertia G;
    Coriolis<A> B;
    Force f, f_interaction;  // required by the motion, and against constraints and loads
  };

  void forward_pass(const LinearizationPoint& at);
  void set_motion(int i, const LinearizationPoint& at, const Motion& V_J);
  void backward_pass(const LinearizationPoint& at, Jacobians& tangent);
  void add_inertia_terms(int i, int k, Jacobians& tangent);
  void tree_load_jacobians(const LinearizationPoint& at, Jacobians& out) const;
  void to_coordinates(const LinearizationPoint& at, const Jacobians& tangent, Jacobians& out) const;

  // Additional terms of joints whose S is not constant (recursive_joints_impl.h).
  void add_variable_subspace(int i, const LinearizationPoint& at);
  void add_shifts_along_axes_of_F(int i, int shifts, const LinearizationPoint& at);
  void add_projection(int i, const LinearizationPoint& at, Jacobians& tangent) const;

  // An interaction between two links a and b, and the paths from them to their nearest common ancestor.
  struct LinkPair {
    std::vector<int> a, b;                       // links of the paths, from the outermost inward
    std::vector<IndexRange> ranges_a, ranges_b;  // their velocities
    Force force;                                 // required by b against the interaction; -force by a
  };
  // The derivatives of S . L, for the motion S of a velocity and the force L that b requires, with respect to the pose
  // X and the velocity U of b as seen from a.
  struct Gradient {
    Force by_X, by_U;
  };
  LinkPair link_pair(std::vector<int> a, std::vector<int> b) const;
  void add_interaction(LinkPair& of, int a, int b, const Force& force);
  template <bool damped, class Changes>
  void add_link_pair_terms(const LinkPair& of, const Motion& V_b, Changes changes, Jacobians& tangent) const;

  // Loads (recursive_loads_impl.h).
  template <class F>
  auto ports_at(const PlacedForce<F>& force) const;
  template <class F>
  PortJacobians port_jacobians(const PlacedForce<F>& force, const double* u) const;
  typename DualAlgebra::Force cut_force(int c, const typename DualAlgebra::Pose& X,
                                        const typename DualAlgebra::Motion& V, const LinearizationPoint& at) const;
  void set_loads(const LinearizationPoint& at, int inputs);
  void set_forces(const LinearizationPoint& at);
  void forces_jacobians(const LinearizationPoint& at, Jacobians& tangent, Jacobians& out);
  void load_jacobians(const LinearizationPoint& at, Jacobians& tangent, Jacobians& out);
  void force_jacobians(const PortJacobians& K, const Attachment& last, const LinkPair& of, Jacobians& tangent) const;
  template <class F>
  void force_input_derivatives(const PlacedForce<F>& force, const LinkPair& of, Jacobians& out);
  void add_input_derivative(const Force& F, const LinkPair& of, int input, Jacobians& out) const;
  void cut_load_jacobians(int c, const LinearizationPoint& at, Jacobians& tangent, Jacobians& out);
  void cut_input_derivatives(int c, const LinearizationPoint& at, Jacobians& out);
  void cut_input_derivative(int c, int input, const typename DualAlgebra::Motion& V, const LinearizationPoint& at,
                            Jacobians& out);

  // Constraint equations of loops (recursive_constraints_impl.h).
  // The constraint equations of a cut at the current position, in F's axes about M's origin.
  struct LocalRows {
    Pose X;         // F's axes at M's origin
    Motion V, W;    // of M in F: velocity, its rate
    bool w_varies;  // the constraint wrenches w change with X
    // By equation: derivatives with respect to rotations and translations of M; those of w and the bias only if w
    // varies.
    Force Phi[6], bias_X[6], bias_V[6];
    Force w[6][A::dimension];  // derivative of w, by direction
  };
  Pose at_M(int c) const;
  void cut_wrench(int c, const LinearizationPoint& at);
  void cut_jacobians(int c, const LinearizationPoint& at, Jacobians& tangent);
  void row_jacobians(int c, const LocalRows& at, Jacobians& tangent);
  void reaction_jacobians(int c, const LocalRows& at, const LinearizationPoint& point, Jacobians& tangent) const;

  const Model<A>& model_;
  const Workspace<A>& ws_;
  const Loads& loads_;
  std::vector<Body> body_;
  std::vector<Motion> S_of_, P_of_, Q_of_, R_of_;  // by velocity
  MotionColumns<A> S_, P_, Q_, R_;                 // the same, by component
  std::vector<std::vector<IndexRange>>
      ranges_to_ground_;  // by link: the velocities from the ground to it, its own included
  std::vector<LinkPair> cuts_, cut_loads_, forces_;
  std::vector<Dual> u_;
  bool has_quaternions_ = false;
  Jacobians tangent_;  // if so: derivatives with respect to displacements (nv) instead of q (nq)
  LocalRows local_;
  std::vector<double> column_q_, column_v_;
};

extern template class RecursiveJacobians<Planar>;
extern template class RecursiveJacobians<Spatial>;

}  // namespace gelenk
