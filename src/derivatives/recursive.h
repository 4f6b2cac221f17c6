// SPDX-License-Identifier: BSD-3-Clause
// The Jacobians of jacobians.h by recursion along the tree: a motion that one speed gives everything outwards meets
// the sums of inertias and forces there, so that each entry of r costs a few scalar products (Carpentier & Mansard
// 2018; Singh, Russell & Wensing 2022). The rows of loops likewise; docs/methods.md has the derivation.
//
// All is written in the root's axes, about a point that moves with the first link: far from the root nothing is lost.
// S_k being the motion that speed k of link i gives, a turn along it moves everything outwards by S_k and, beyond that,
// changes velocities by P_k and accelerations by P_k x V + Q_k; speed k itself changes velocities by S_k and
// accelerations by S_k x V + R_k. With the link p inwards of i
//   P_k = V_p x S_k + e_k,   Q_k = A_p x S_k + V_p x P_k + V_i x e_k + E_k,   R_k = V_p x S_k + V_i x S_k + b_k,
// where e, E, b are of joints whose motions S change with their coordinates: the slopes in M of S v and of
// S vdot + Sdot v by the turn, and of Sdot v by the speed.
#pragma once

#include <vector>

#include "derivatives/coriolis.h"
#include "derivatives/jacobians.h"
#include "kinematics/kernels.h"
#include "kinematics/motion_columns.h"
#include "math/dual.h"

namespace gelenk {

template <class A>
class RecursiveJacobians {
 public:
  // model, ws and loads outlive it. ws: poses, motion spaces and rows of the position.
  RecursiveJacobians(const Model<A>& model, const Workspace<A>& ws, const Loads& loads);

  // inputs: number of the scene's inputs. Allocates when called first, and when `out` has other sizes.
  void operator()(const LinearizationPoint& at, int inputs, Jacobians& out);

 private:
  using Motion = typename A::Motion;
  using Force = typename A::Force;
  using Pose = typename A::Pose;
  using Dually = std::conditional_t<A::planar, PlanarAlgebra<Dual>, SpatialAlgebra<Dual>>;

  struct Body {
    Pose X;
    Motion V, acc;
    // Of everything from it outwards: also the force that the motion needs, and that against rows and loads.
    typename A::Inertia G;
    Coriolis<A> B;
    Force f, against;
  };

  void move_outwards(const LinearizationPoint& at);
  void set_speeds(int i, const LinearizationPoint& at, const Motion& V_J);
  void gather_inwards(const LinearizationPoint& at, Jacobians& by);
  void add_pairs(int i, int k, Jacobians& by);
  void joint_loads(const LinearizationPoint& at, Jacobians& out) const;
  void to_numbers(const LinearizationPoint& at, const Jacobians& by, Jacobians& out) const;

  // Of joints whose motions change with their coordinates: what they add (recursive_joints_impl.h).
  void add_turning(int i, const LinearizationPoint& at);
  void add_turned_shifts(int i, int shifts, const LinearizationPoint& at);
  void add_projection(int i, const LinearizationPoint& at, Jacobians& by) const;

  // What acts between two links, up to their nearest common ancestor.
  struct Pair {
    std::vector<int> a, b;            // links, from the outermost inwards
    std::vector<Run> runs_a, runs_b;  // their speeds
    Force needed;                     // what b needs against it, and a the other way
  };
  // S . L's slopes for the motion S of a speed, L being what b needs: by where b stands and how it moves, seen from a.
  struct Change {
    Force by_X, by_U;
  };
  Pair pair(std::vector<int> a, std::vector<int> b) const;
  void need(Pair& of, int a, int b, const Force& force);
  template <bool damped, class Changes>
  void add_pair(const Pair& of, const Motion& V_b, Changes changes, Jacobians& by) const;

  // Loads (recursive_loads_impl.h).
  template <class F>
  auto ports_at(const PlacedForce<F>& force) const;
  template <class F>
  PortJacobians port_jacobians(const PlacedForce<F>& force, const double* u) const;
  typename Dually::Force cut_force(int c, const typename Dually::Pose& X, const typename Dually::Motion& V,
                                   const LinearizationPoint& at) const;
  void set_loads(const LinearizationPoint& at, int inputs);
  void load_jacobians(const LinearizationPoint& at, Jacobians& by, Jacobians& out);
  void force_jacobians(const PortJacobians& K, const Attachment& last, const Pair& of, Jacobians& by) const;
  template <class F>
  void force_input_derivatives(const PlacedForce<F>& force, const Pair& of, const double* u, Jacobians& out) const;
  void add_input_derivative(const Force& F, const Pair& of, int input, Jacobians& out) const;
  void cut_load_jacobians(int c, const LinearizationPoint& at, Jacobians& by, Jacobians& out);
  void cut_input_derivatives(int c, const LinearizationPoint& at, Jacobians& out);
  void cut_input_derivative(int c, int input, const typename Dually::Motion& V, const LinearizationPoint& at,
                            Jacobians& out);

  // Rows of loops (recursive_constraints_impl.h).
  // What the rows of a cut are like where it stands; all in F's axes about M's origin.
  struct LocalRows {
    Pose X;       // F's axes at M's origin
    Motion V, W;  // of M in F: velocity, its rate
    bool moving;  // w changes with X
    // By row: slopes by the turns and shifts of M; those of w and of the bias only where w moves.
    Force Phi[6], bias_X[6], bias_V[6];
    Force w[6][A::dimension];  // by direction
  };
  Pose at_M(int c) const;
  void cut_wrench(int c, const LinearizationPoint& at);
  void cut_jacobians(int c, const LinearizationPoint& at, Jacobians& by);
  void row_jacobians(int c, const LocalRows& at, Jacobians& by);
  void reaction_jacobians(int c, const LocalRows& at, const LinearizationPoint& point, Jacobians& by) const;

  const Model<A>& model_;
  const Workspace<A>& ws_;
  const Loads& loads_;
  std::vector<Body> body_;
  std::vector<Motion> S_of_, P_of_, Q_of_, R_of_;  // by speed
  MotionColumns<A> S_, P_, Q_, R_;                 // the same
  std::vector<std::vector<Run>> inwards_;          // by link: the speeds from the ground to it, its own included
  std::vector<Pair> cuts_, cut_loads_, forces_;
  std::vector<Dual> u_;
  bool other_numbers_ = false;  // than turns are in q
  Jacobians turned_;            // by turns, if so
  LocalRows local_;
  std::vector<double> column_q_, column_v_;
};

extern template class RecursiveJacobians<Planar>;
extern template class RecursiveJacobians<Spatial>;

}  // namespace gelenk
