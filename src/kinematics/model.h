// SPDX-License-Identifier: BSD-3-Clause
// The mechanism and the loads on it in the form in which the kernels read them: flat, in depth-first order, in one
// algebra.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>
#include <vector>

#include "element/cut_joint.h"
#include "kinematics/branches.h"
#include "kinematics/branching_forces.h"
#include "math/pose_in.h"
#include "mechanism/mechanism.h"

namespace gelenk {

static_assert(Rod::max_nq <= max_cut_nq && Rod::max_nv <= max_cut_nv);  // of all cut joints, a rod has the most

// A frame on a link. In planar mechanisms its height above the plane is height + p.z().
struct Attachment {
  int link = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      // m, in the link's frame
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // its axes, in the link's
  double height = 0;                                // m, of the link's origin along the plane's normal; 0 in space
};

// A force and the frames on which it acts.
template <class F>
struct PlacedForce {
  static constexpr std::size_t ports = std::size(F::ports);

  F element;
  std::array<Attachment, ports> at;
  int input = 0;   // index of its first input in the scene
  int force = -1;  // index in the scene
};

// A force along a joint coordinate. Its element uses the user's coordinate: sign times the mechanism's.
template <class F>
struct AlongCoordinate {
  F element;
  int q = 0, v = 0;
  double sign = 1;
  int input = 0;                  // index of its first input in the scene
  int joint = -1, component = 0;  // joint of the scene, and which of its coordinates

  // Generalized force [N m, N], in the mechanism's sign. u: all inputs of the scene.
  template <class T>
  T effort(const T* at, const T* speed, const T* u) const {
    return T(sign) * element.effort(T(T(sign) * at[q]), T(T(sign) * speed[v]), u + input);
  }
  // The same on a given branch (element/coordinate_force.h).
  template <class T>
  T held(int side, const T* at, const T* speed, const T* u) const {
    return T(sign) * element.held(side, T(T(sign) * at[q]), T(T(sign) * speed[v]), u + input);
  }
  // The branch on which the state is.
  template <class T>
  int side(const T* at, const T* speed) const {
    return element.side(T(T(sign) * at[q]), T(T(sign) * speed[v]));
  }
};

namespace detail {

template <class F>
struct Plain {
  using type = F;
};
template <class F>
struct Plain<std::optional<F>> {
  using type = F;
};

// A tuple with a list for each kind of element.
template <class Any, class Tuple>
struct Lists;
template <class... Motor, class... Force>
struct Lists<std::variant<Motor...>, std::tuple<Force...>> {
  using type =
      std::tuple<std::vector<AlongCoordinate<Motor>>..., std::vector<AlongCoordinate<typename Plain<Force>::type>>...>;
};
template <class... Force>
struct Lists<std::variant<Force...>, void> {
  using type = std::tuple<std::vector<PlacedForce<Force>>...>;
};

}  // namespace detail

using PlacedForces = detail::Lists<AnyForce::variant, void>::type;

// Calls visit(list) for the list of each kind. Inline: most lists are empty, in every evaluation.
template <class L, class Visit>
[[gnu::always_inline]] inline void each_list(L& lists, Visit&& visit) {
  std::apply([&](auto&... list) __attribute__((always_inline)) { (visit(list), ...); }, lists);
}
template <class L>
bool all_empty(const L& lists) {
  return std::apply([](const auto&... list) { return (list.empty() && ...); }, lists);
}

// Motors, springs, dampers and stops along joints: of the whole tree, or of one cut joint (then the indices are
// relative to those of the joint).
struct JointLoads {
  using Lists = detail::Lists<AnyMotor::variant, JointForces::tuple>::type;
  Lists lists;

  bool empty() const { return all_empty(lists); }
  bool stores_nothing() const;  // no element has potential energy
  // Adds the generalized forces to tau. u: all inputs of the scene. sides: the modes in which the forces with modes are
  // held, or null: each is in that of the state.
  template <class T>
  void add(const T* q, const T* v, const T* u, T* tau, const int* sides = nullptr) const {
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        if constexpr (HasBranches<std::decay_t<decltype(force.element)>>) {
          const int held = sides == nullptr ? branch_of_state : *sides++;
          tau[force.v] += force.held(held == branch_of_state ? force.side(q, v) : held, q, v, u);
        } else {
          tau[force.v] += force.effort(q, v, u);
        }
      }
    });
  }
  // Potential energy [J].
  template <class T>
  T energy(const T* q) const {
    T sum(0);
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        const auto& element = force.element;
        if constexpr (requires { element.energy(q[0]); }) sum += element.energy(T(T(force.sign) * q[force.q]));
      }
    });
    return sum;
  }
  // Number of forces with branches.
  int branchings() const {
    int n = 0;
    each_branching([&](const auto&) { ++n; });
    return n;
  }
  bool has_branches() const { return branchings() > 0; }
  // Calls visit(force) for each force with branches.
  template <class Visit>
  void each_branching(Visit&& visit) const {
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        if constexpr (HasBranches<std::decay_t<decltype(force.element)>>) visit(force);
      }
    });
  }
};

struct Loads {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();   // m/s2, in the root's axes
  Eigen::Matrix3d R_0W = Eigen::Matrix3d::Identity();  // the world's axes, in the root's
  PlacedForces forces;
  JointLoads tree;
  std::vector<JointLoads> cuts;       // by cut
  std::vector<double> added_inertia;  // kg m2 (kg), by velocity: of motors
  std::vector<ContactLaw> contacts;   // by contact of the scene
  std::vector<int> inputs;            // indices of the scene's inputs that act on this island
  bool only_along_tree = false;       // no force acts on links or along cuts
  // J: the part of gravity's potential energy that the kernels omit, between the origins of the world and the root
  // and, in planar mechanisms, along the normal.
  double potential_offset = 0;
};

// Links whose poses in the root frame are required by the loads, and their ancestors.
std::vector<int> links_with_loads(const Mechanism& mechanism, const Loads& loads);

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
