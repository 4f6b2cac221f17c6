// SPDX-License-Identifier: BSD-3-Clause
// A mechanism and the loads on it, as the kernels read them: flat, in depth-first order, in one algebra.
#pragma once

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "math/pose_in.h"
#include "mechanism/mechanism.h"

namespace gelenk {

// A point on a link. Planar kernels know its height through `height` and p.z().
struct Attachment {
  int link = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // m, in the link's frame
  double height = 0;                            // m, of the link's origin along the plane's normal; 0 in space
};

struct PointSpring {
  Attachment from, to;
  double stiffness = 0, damping = 0, length = 0;
  int force = -1;  // of the scene

  // It pulls with stiffness times the way between its ends, smooth also where these meet. Any other one has a direction
  // that is not defined there.
  bool is_linear() const { return length == 0 && damping == 0; }
};

struct Wrench {
  Attachment at;
  Eigen::Vector3d force, torque;  // constant part, in the link's axes (in_link) or the root's
  bool in_link = false;
  Eigen::Matrix3d R_user;  // from the axes in which the inputs are given to those above
  int input = -1;          // first of six inputs (force, torque), -1: none
};

// tau[v] = gain * input.
struct Actuation {
  int v = 0;
  int input = 0;
  double gain = 1;
};
// tau[v] = -stiffness (q[q] - reference) - damping v[v].
struct JointSpring {
  int q = 0, v = 0;
  double stiffness = 0, damping = 0, reference = 0;
};
// tau[v] = what the stop gives at q[q], v[v]; bounds in the mechanism's own sign.
struct JointStop {
  int q = 0, v = 0;
  Stop stop;

  // In the direction of the speed, by the branch it is on: 1 at the upper bound, -1 at the lower one, 0 at none.
  template <class T>
  T effort(int side, const T& at, const T& speed) const {
    if (side > 0) return -(T(stop.stiffness) * (at - T(stop.upper)) + T(stop.damping) * speed);
    if (side < 0) return T(stop.stiffness) * (T(stop.lower) - at) - T(stop.damping) * speed;
    return T(0);
  }
  // The branch on which a state lies: it pushes, or there is none.
  template <class T>
  int side(const T& at, const T& speed) const {
    if (at > T(stop.upper)) return effort(1, at, speed) < T(0) ? 1 : 0;
    if (at < T(stop.lower)) return effort(-1, at, speed) > T(0) ? -1 : 0;
    return 0;
  }
  template <class T>
  T effort(const T& at, const T& speed) const {
    return effort(side(at, speed), at, speed);
  }
};
// J: stored in a stop at the coordinate q.
template <class T>
T energy_of(const Stop& stop, const T& q) {
  const T depth = std::max({T(q - stop.upper), T(stop.lower - q), T(0)});
  return stop.stiffness / 2 * depth * depth;
}
// Drives, springs and stops along joints: of the whole tree, or of one cut joint (indices from its own first).
struct JointLoads {
  std::vector<Actuation> actuations;
  std::vector<JointSpring> springs;
  std::vector<JointStop> stops;

  bool empty() const { return actuations.empty() && stores_nothing(); }
  bool stores_nothing() const { return springs.empty() && stops.empty(); }
  // sides: the branches on which stops are held, or null: each is on that of the state.
  template <class T>
  void add(const T* q, const T* v, const T* u, T* tau, const int* sides = nullptr) const {
    for (const Actuation& drive : actuations) tau[drive.v] += T(drive.gain) * u[drive.input];
    for (const JointSpring& s : springs) {
      tau[s.v] -= T(s.damping) * v[s.v];
      if (s.stiffness != 0) tau[s.v] -= T(s.stiffness) * (q[s.q] - T(s.reference));
    }
    for (const JointStop& s : stops) {
      const int side = sides == nullptr ? s.side(q[s.q], v[s.v]) : *sides++;
      tau[s.v] += s.effort(side, q[s.q], v[s.v]);
    }
  }
  // J, stored in springs and stops.
  template <class T>
  T energy(const T* q) const {
    T sum(0);
    for (const JointSpring& s : springs) {
      if (s.stiffness != 0) sum += s.stiffness / 2 * (q[s.q] - s.reference) * (q[s.q] - s.reference);
    }
    for (const JointStop& s : stops) sum += energy_of(s.stop, q[s.q]);
    return sum;
  }
};

struct Loads {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // in the root's axes
  std::vector<PointSpring> springs;
  std::vector<Wrench> wrenches;
  JointLoads tree;
  std::vector<JointLoads> cuts;           // by cut
  std::vector<double> reflected_inertia;  // by speed: gear_ratio^2 rotor_inertia
  std::vector<int> inputs;                // those that act here
  // J: potential energy of gravity that the kernels do not see, from the world's origin to the root's and, in planar
  // mechanisms, along the normal.
  double potential_offset = 0;
};

// Signs and places of the scene's loads, by island. Inputs are numbered as in scene/signals.h.
std::vector<Loads> make_loads(const Scene& scene, const ReducedScene& reduced);

// Likewise, but over loads of the same scene with other numbers, which costs nothing of the heap then. Keeps to both.
class LoadMaker {
 public:
  LoadMaker(const Scene& scene, const ReducedScene& reduced);
  void fill(std::vector<Loads>& loads) const;

 private:
  const Scene& scene_;
  const ReducedScene& reduced_;
  std::unordered_map<std::string_view, int> body_number_, joint_number_;
};

// J: potential energy of what stands still, bodies, springs and stops, zero at the world's origin.
double standing_energy(const Scene& scene, const ReducedScene& reduced);

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
    bool plain;  // S constant, qdot = v (PlainJoint with constant axis): no visit needed for either
    bool turns;  // revolute: turning.h
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
    std::vector<bool> turns;
    typename A::Pose X_AF, X_BM;
    std::vector<int> path_a, path_b;
    int first_path;  // of its links in Workspace::X_FL: those of path_a, then those of path_b
    CutJoint joint;
  };
  std::vector<Link> links;
  std::vector<Cut> cuts;
  std::vector<CoordinateRow> coordinate_rows;
  int nq, nv, rows, cut_nq, cut_nv;
  int path_links = 0;  // of all cuts
  int first_coordinate_row;
  bool mass_needs_rows;  // see Mechanism

  explicit Model(const Mechanism& mechanism);
};

}  // namespace gelenk
