// SPDX-License-Identifier: BSD-3-Clause
// Where and how the features of two shapes touch or nearly do, in the root frame: tips on cores, corners on faces,
// edges that cross, rims above planes. T: double or, for derivatives, Dual; which part of a feature is nearest is
// decided by the values.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "contact_geometry/contact_candidate.h"

namespace gelenk::features {

// Edges with a smaller sine of the angle between them count as parallel.
inline constexpr double least_sine = 1e-4;
// A cylinder whose axis has a smaller sine of the angle to the normal of a plane is on its flat end.
inline constexpr double flat_sine = 1e-3;
// Beyond the ends of features by less than this, shapes still touch there [natural units of length].
inline constexpr double near_tolerance = 1e-10;
// What is nearer to a point or an edge of a core than this fraction of the radii counts as being on it.
inline constexpr double least_distance = 1e-12;
// Below this sine, the direction of the tilt is arbitrary.
inline constexpr double no_tilt = 1e-12;

// Of the links of a pair, and of the shape that is the core.
template <class T>
struct PairMotion {
  using Pose = typename SpatialAlgebra<T>::Pose;
  using Motion = typename SpatialAlgebra<T>::Motion;

  Pose tip, core, S;
  Motion V_tip, V_core;  // in and about the root frame

  // Of the tip's link relative to the core's.
  Vector3<T> velocity(const Vector3<T>& p) const {
    const Motion V = V_tip - V_core;
    return V.v + V.w.cross(p);
  }
};

// From the nearest point of the core's box to the center of the tip, in S.
template <class T>
struct Line {
  Vector3<T> x, normal;
  Eigen::Vector3d free;  // 1 where the nearest point does not follow the center, else 0
  T distance{0};
};

template <class T>
T length(const Vector3<T>& a) {
  using std::sqrt;
  return sqrt(a.squaredNorm());
}

// x: the center of the tip, in S.
template <class T>
Line<T> line(const ContactCandidate& candidate, const Vector3<T>& x) {
  const auto unit = [](int axis, double sign) -> Vector3<T> {
    return Eigen::Vector3d(sign * Eigen::Vector3d::Unit(axis)).cast<T>();
  };
  const auto size_of = [](const T& a) { return a < T(0) ? T(-a) : a; };
  Line<T> out;
  out.x = x;
  if (candidate.kind == ContactCandidate::Kind::corner) {
    const int axis = candidate.face % 3;
    out.free = Eigen::Vector3d::Unit(axis);
    out.normal = unit(axis, candidate.face < 3 ? 1 : -1);
    out.distance = out.normal.dot(out.x) - T(candidate.box.half[axis]);
    return out;
  }
  if (candidate.box.half_space) {
    out.free = Eigen::Vector3d::UnitZ();
    out.normal = unit(2, 1);
    out.distance = out.x.z();
    return out;
  }
  const Eigen::Vector3d& half = candidate.box.half;
  Vector3<T> way = Vector3<T>::Zero();
  for (int k = 0; k < 3; ++k) {
    // Where the box has no extent, its nearest point never follows the center.
    const bool beyond = half[k] == 0 || size_of(out.x[k]) > T(half[k]);
    out.free[k] = beyond ? 1 : 0;
    if (beyond) way[k] = out.x[k] - T(out.x[k] < T(0) ? -half[k] : half[k]);
  }
  out.distance = length(way);
  if (out.distance > T(least_distance * (candidate.radius + candidate.box.radius))) {
    out.normal = way / out.distance;
    return out;
  }
  // Inside: the nearest face.
  int axis = 0;
  Vector3<T> depth;
  for (int k = 0; k < 3; ++k) depth[k] = T(half[k]) - size_of(out.x[k]);
  for (int k = 1; k < 3; ++k) axis = depth[k] < depth[axis] ? k : axis;
  out.free = Eigen::Vector3d::Unit(axis);
  out.normal = unit(axis, out.x[axis] < T(0) ? -1 : 1);
  out.distance = -depth[axis];
  return out;
}

template <class T>
CandidateStateOf<T> state_of_tip(const ContactCandidate& candidate, const PairMotion<T>& at) {
  const Vector3<T> center = at.tip.point(candidate.center.cast<T>());
  const Line<T> way = line<T>(candidate, at.S.R.transpose() * (center - at.S.p));
  const Vector3<T> center_dot = at.V_tip.v + at.V_tip.w.cross(center);
  const Vector3<T> x_dot = at.S.R.transpose() * at.velocity(center);
  const Vector3<T> way_dot = way.free.template cast<T>().cwiseProduct(x_dot);
  CandidateStateOf<T> out;
  out.gap = way.distance - T(candidate.box.radius) - T(candidate.radius);
  out.n = at.S.R * way.normal;
  out.rate = way.normal.dot(way_dot);
  out.n_dot = at.V_core.w.cross(out.n);
  const bool is_flat = candidate.box.half_space || candidate.kind == ContactCandidate::Kind::corner;
  if (!is_flat && way.distance > T(0)) out.n_dot += at.S.R * (way_dot - out.rate * way.normal) / way.distance;
  const T arm = T(candidate.radius) + out.gap / T(2);
  out.p = center - arm * out.n;
  out.p_dot = center_dot - arm * out.n_dot - out.rate / T(2) * out.n;
  return out;
}

// An edge of each shape.
template <class T>
struct PlacedEdges {
  struct Placed {
    Vector3<T> center, direction;
    Vector3<T> outward{Vector3<T>::Zero()};  // of a sharp edge: the sum of the normals of its faces
  };
  Placed tip, core;

  static PlacedEdges of(const ContactCandidate& candidate, const PairMotion<T>& at) {
    const auto place = [](const typename PairMotion<T>::Pose& X, const SolidEdge& edge) {
      Placed out;
      out.center = X.point(edge.center.cast<T>());
      out.direction = X.R * edge.direction.cast<T>();
      if (edge.is_sharp()) out.outward = X.R * Vector3<T>((edge.normals[0] + edge.normals[1]).cast<T>());
      return out;
    };
    return {place(at.tip, candidate.tip_edge), place(at.core, candidate.core_edge)};
  }
};

// The points of two lines next to each other.
template <class T>
struct Crossing {
  Vector3<T> a, b;      // directions, of the tip and the core
  Vector3<T> d;         // from the center of the core's edge to that of the tip's
  Vector3<T> c, n;      // a x b; unit normal, from the core to the tip
  Vector3<T> p_a, p_b;  // m
  T s{0}, t{0};         // m, along the edges from their centers
  T sine{0};            // of the angle between them
  double sign = 1;      // of n relative to c
  T gap{0};             // m

  bool is_parallel() const { return !(sine > T(no_tilt)); }
};

template <class T>
Crossing<T> crossing(const ContactCandidate& candidate, const PlacedEdges<T>& at) {
  const SolidEdge& tip = candidate.tip_edge;
  const SolidEdge& core = candidate.core_edge;
  Crossing<T> out;
  out.a = at.tip.direction;
  out.b = at.core.direction;
  out.d = at.tip.center - at.core.center;
  out.c = out.a.cross(out.b);
  out.sine = length(out.c);
  if (out.is_parallel()) {
    out.n = Eigen::Vector3d::UnitZ().cast<T>();
    out.p_a = at.tip.center;
    out.p_b = at.core.center;
    out.gap = T(candidate.size);
    return out;
  }
  Vector3<T> outward = out.d;
  if (core.is_sharp()) {
    outward = at.core.outward;
  } else if (tip.is_sharp()) {
    outward = -at.tip.outward;
  }
  out.sign = out.c.dot(outward) < T(0) ? -1 : 1;
  out.n = T(out.sign) / out.sine * out.c;
  const T k = out.a.dot(out.b);
  const T D = out.sine * out.sine;
  const T d_a = out.d.dot(out.a);
  const T d_b = out.d.dot(out.b);
  out.s = (k * d_b - d_a) / D;
  out.t = (d_b - k * d_a) / D;
  out.p_a = at.tip.center + out.s * out.a;
  out.p_b = at.core.center + out.t * out.b;
  out.gap = out.n.dot(out.d) - T(tip.radius) - T(core.radius);
  return out;
}

template <class T>
CandidateStateOf<T> state_of_edges(const ContactCandidate& candidate, const Crossing<T>& at,
                                   const PairMotion<T>& motion) {
  using Motion = typename PairMotion<T>::Motion;
  const Motion& V_a = motion.V_tip;
  const Motion& V_b = motion.V_core;
  CandidateStateOf<T> out;
  out.gap = at.gap;
  out.n = at.n;
  out.p = at.p_b + (T(candidate.core_edge.radius) + at.gap / T(2)) * at.n;
  const auto velocity_of = [](const Motion& V, const Vector3<T>& p) { return Vector3<T>(V.v + V.w.cross(p)); };
  out.rate = at.n.dot(velocity_of(V_a, at.p_a) - velocity_of(V_b, at.p_b));
  out.n_dot.setZero();
  out.p_dot.setZero();
  if (at.is_parallel()) return out;
  const Vector3<T> a_dot = V_a.w.cross(at.a);
  const Vector3<T> b_dot = V_b.w.cross(at.b);
  const Vector3<T> c_dot = a_dot.cross(at.b) + at.a.cross(b_dot);
  out.n_dot = T(at.sign) / at.sine * (c_dot - at.n.dot(c_dot) * at.n);
  // The rates of s and t, from (d + s a - t b) . a = 0 and (d + s a - t b) . b = 0.
  const Vector3<T> center_a = at.p_a - at.s * at.a;
  const Vector3<T> center_b = at.p_b - at.t * at.b;
  const Vector3<T> d_dot = velocity_of(V_a, center_a) - velocity_of(V_b, center_b);
  const Vector3<T> r = at.p_a - at.p_b;
  const Vector3<T> r_dot = d_dot + at.s * a_dot - at.t * b_dot;
  const T right_a = -(r_dot.dot(at.a) + r.dot(a_dot));
  const T right_b = -(r_dot.dot(at.b) + r.dot(b_dot));
  const T k = at.a.dot(at.b);
  const T D = at.sine * at.sine;
  const T t_dot = (k * right_a - right_b) / D;
  const Vector3<T> p_b_dot = velocity_of(V_b, center_b) + t_dot * at.b + at.t * b_dot;
  out.p_dot = p_b_dot + (T(candidate.core_edge.radius) + at.gap / T(2)) * out.n_dot + out.rate / T(2) * at.n;
  return out;
}

// The point of a rim that is lowest above a plane.
template <class T>
struct Lowest {
  Vector3<T> n, axis, c;  // normal, unit axis, center of the rim
  Vector3<T> e;           // unit, from the lowest point to the center
  T sine{0};              // of the angle between n and the axis
  T gap{0};               // m
};

template <class T>
Lowest<T> lowest(const ContactCandidate& candidate, const typename PairMotion<T>::Pose& tip,
                 const typename PairMotion<T>::Pose& S) {
  Lowest<T> out;
  out.n = S.R.col(2);
  out.axis = tip.R * candidate.tip_edge.direction.cast<T>();
  out.c = tip.point(candidate.tip_edge.center.cast<T>());
  const Vector3<T> across = out.n - out.n.dot(out.axis) * out.axis;
  out.sine = length(across);
  if (out.sine > T(no_tilt)) {
    out.e = across / out.sine;
  } else {
    out.e = out.axis.unitOrthogonal();
  }
  out.gap = out.n.dot(out.c - S.p) - T(candidate.radius) * out.sine - T(candidate.crown);
  return out;
}

template <class T>
CandidateStateOf<T> state_of_rim(const ContactCandidate& candidate, const PairMotion<T>& motion) {
  const Lowest<T> at = lowest<T>(candidate, motion.tip, motion.S);
  const auto& V_tip = motion.V_tip;
  const auto& V_core = motion.V_core;
  CandidateStateOf<T> out;
  out.gap = at.gap;
  out.n = at.n;
  out.n_dot = V_core.w.cross(at.n);
  const Vector3<T> lowest_point = at.c - T(candidate.radius) * at.e;
  const T arm = T(candidate.crown) + at.gap / T(2);
  out.p = lowest_point - arm * at.n;
  const Vector3<T> relative = V_tip.v + V_tip.w.cross(lowest_point) - V_core.v - V_core.w.cross(lowest_point);
  out.rate = at.n.dot(relative);
  Vector3<T> e_dot = Vector3<T>::Zero();
  if (at.sine > T(no_tilt)) {
    const Vector3<T> axis_dot = V_tip.w.cross(at.axis);
    const T cosine_rate = out.n_dot.dot(at.axis) + at.n.dot(axis_dot);
    const Vector3<T> across_dot = out.n_dot - cosine_rate * at.axis - at.n.dot(at.axis) * axis_dot;
    e_dot = (across_dot - at.e.dot(across_dot) * at.e) / at.sine;
  }
  out.p_dot = V_tip.v + V_tip.w.cross(at.c) - T(candidate.radius) * e_dot - out.rate / T(2) * at.n - arm * out.n_dot;
  return out;
}

// Of the unit axes a and b with the largest angle L: (a . b - cos L) / sin L, which at contact is L less the angle, to
// first order, and is smooth everywhere. Differences of nearly equal numbers are avoided.
template <class T>
T gap_of_swing(const ContactCandidate& candidate, const Vector3<T>& a, const Vector3<T>& b) {
  const double half_sine = std::sin(candidate.swing / 2), half_cosine = std::cos(candidate.swing / 2);
  const double sine = 2 * half_sine * half_cosine;
  if (half_sine < half_cosine) return (T(2 * half_sine * half_sine) - (a - b).squaredNorm() / T(2)) / T(sine);
  return ((a + b).squaredNorm() / T(2) - T(2 * half_cosine * half_cosine)) / T(sine);
}

template <class T>
CandidateStateOf<T> state_of_swing(const ContactCandidate& candidate, const PairMotion<T>& at) {
  const Vector3<T> a = at.core.R * candidate.core_axis.cast<T>();
  const Vector3<T> b = at.tip.R * candidate.tip_axis.cast<T>();
  const T sine = T(std::sin(candidate.swing));
  CandidateStateOf<T> out;
  out.p.setZero();
  out.p_dot.setZero();
  out.gap = gap_of_swing<T>(candidate, a, b);
  out.n = b.cross(a) / sine;
  const Vector3<T> a_dot = at.V_core.w.cross(a);
  const Vector3<T> b_dot = at.V_tip.w.cross(b);
  out.n_dot = (b_dot.cross(a) + b.cross(a_dot)) / sine;
  out.rate = out.n.dot(at.V_tip.w - at.V_core.w);
  return out;
}

// At the joint, with a normal that is fixed to the core's link.
template <class T>
CandidateStateOf<T> state_of_friction(const ContactCandidate& candidate, const PairMotion<T>& at) {
  CandidateStateOf<T> out;
  out.p = at.tip.point(candidate.center.cast<T>());
  out.p_dot = at.V_tip.v + at.V_tip.w.cross(out.p);
  out.n = at.core.R * candidate.core_axis.cast<T>();
  out.n_dot = at.V_core.w.cross(out.n);
  return out;
}

template <class T>
CandidateStateOf<T> state(const ContactCandidate& candidate, const PairMotion<T>& at) {
  switch (candidate.kind) {
    case ContactCandidate::Kind::swing:
      return state_of_swing(candidate, at);
    case ContactCandidate::Kind::friction:
      return state_of_friction(candidate, at);
    case ContactCandidate::Kind::edges:
      return state_of_edges(candidate, crossing(candidate, PlacedEdges<T>::of(candidate, at)), at);
    case ContactCandidate::Kind::rim:
      return state_of_rim(candidate, at);
    default:
      return state_of_tip(candidate, at);
  }
}

}  // namespace gelenk::features
