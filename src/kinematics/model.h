// SPDX-License-Identifier: BSD-3-Clause
// The mechanism in the form in which the kernels read it: flat, in depth-first order, in one algebra.
#pragma once

#include <vector>

#include "element/constraints/cut_joint.h"
#include "math/pose_in.h"
#include "mechanism/mechanism.h"

namespace gelenk {

static_assert(Rod::max_nq <= max_cut_nq && Rod::max_nv <= max_cut_nv);  // of all cut joints, a rod has the most

template <class A>
typename A::Inertia inertia_in(const Spatial::Inertia& G) {
  using T = typename A::Scalar;
  if constexpr (A::planar) {
    return {T(G.m), T(G.h.x()), T(G.h.y()), T(G.I(2, 2))};
  } else {
    return {T(G.m), G.h.cast<T>(), G.I.cast<T>()};
  }
}

template <class A>
struct Model {
  struct Link {
    int parent;
    int iq, iv, nq, nv;
    bool constant_subspace;    // S is constant and qdot = v: neither needs a visit
    bool is_revolute_about_z;  // see revolute_kernels.h
    TreeJoint joint;
    typename A::Pose X_PJ;
    typename A::Inertia G;
  };
  struct Cut {
    int link_a, link_b;
    int first_row, rows;
    bool all_rows;
    std::vector<int> kept;
    int iq, iv, nq, nv;
    std::vector<bool> is_angle;
    typename A::Pose X_AF, X_BM;
    std::vector<int> path_a, path_b;
    int first_path;  // of its links in Workspace::X_FL: those of path_a, then those of path_b
    CutJoint joint;
  };
  std::vector<Link> links;
  std::vector<Cut> cuts;
  std::vector<CoordinateRow> coordinate_rows;
  int nq, nv, rows, cut_nq, cut_nv;
  int path_links = 0;  // number of links on the paths of all cuts
  int first_coordinate_row;
  bool mass_needs_rows;  // see Mechanism

  explicit Model(const Mechanism& mechanism);
};

}  // namespace gelenk
