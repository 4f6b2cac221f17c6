// SPDX-License-Identifier: BSD-3-Clause
// Implementation of Rod for any algebra; rod.cpp has the instances for double, rod_dual.cpp those for derivatives.
#pragma once

#include <cmath>
#include <numbers>

#include "joint/rod.h"
#include "util/unreachable.h"

namespace gelenk {
namespace rods {

// If the angle about the axis on the neighbor changes by less than this [rad] with the sign of h (see aim()), the rod
// has crossed this axis in a straight line.
inline constexpr double crossing_tolerance = 1e-6;
// Length of the sum of two unit vectors below which they are opposite, so that the axis of the rotation from one to the
// other is undetermined.
inline constexpr double opposite_tolerance = 1e-12;

// Calls the function with the joint at an end of the rod: in planar algebra a hinge, in space a spherical or universal
// joint.
template <class A, class Function>
decltype(auto) visit_end(const Rod::End& end, Function&& function) {
  using Any = std::conditional_t<A::planar, Revolute, Spherical>;
  using Result = std::invoke_result_t<Function, const Any&>;
  return std::visit(
      [&](const auto& joint) -> Result {
        if constexpr (A::planar == (std::decay_t<decltype(joint)>::planar == PlanarRole::normal)) {
          return function(joint);
        } else {
          unreachable();  // make_rod() excludes it
        }
      },
      end);
}

// --- aim(): the coordinates with X_FM(q) d_M = d_F, for unit vectors; rod_in_M: d_M is constant, otherwise d_F ---

template <class T>
void aim(const Revolute&, bool, const Vector3<T>& d_M, const Vector3<T>& d_F, T* q) {
  using std::atan2;
  q[0] = atan2(d_M.x() * d_F.y() - d_M.y() * d_F.x(), d_M.x() * d_F.x() + d_M.y() * d_F.y());
}

template <class T>
void aim(const Spherical&, bool, const Vector3<T>& d_M, const Vector3<T>& d_F, T* q) {
  const Vector3<T> sum = d_M + d_F;
  const T sum_norm = sum.norm();  // 2 cos(angle / 2)
  T found[4] = {T(0), T(0), T(0), T(0)};
  if (value_of(sum_norm) > opposite_tolerance) {
    const Vector3<T> u = d_M.cross(d_F) / sum_norm;
    for (int i = 0; i < 3; ++i) found[i] = u[i];
    found[3] = sum_norm / T(2);
  } else {  // half a turn about any axis normal to both
    const Eigen::Vector3d m(value_of(d_M.x()), value_of(d_M.y()), value_of(d_M.z()));
    const Eigen::Vector3d u = m.unitOrthogonal();
    for (int i = 0; i < 3; ++i) found[i] = T(u[i]);
  }
  quaternion::normalize(found);
  T cosine(0);
  for (int i = 0; i < 4; ++i) cosine += found[i] * q[i];
  for (int i = 0; i < 4; ++i) q[i] = cosine < T(0) ? T(-found[i]) : found[i];
}

// Let u be the direction between the two rotations: Rot_x(phi_a) u = d_F and Rot_b(phi_b) d_M = u. Its x component is
// that of d_F and its b component that of d_M, which leaves two possible z components, h and -h. h is zero only if the
// rod is along the axis on the neighbor; a motion that avoids this position keeps the sign. If the rod crosses this
// axis in a straight line, the sign changes and the angle about the axis remains continuous.
template <class T>
void aim(const Universal& joint, bool rod_in_M, const Vector3<T>& d_M, const Vector3<T>& d_F, T* q) {
  using std::atan2;
  using std::sqrt;
  const double c = joint.cos_beta;
  const double s = joint.sin_beta;
  // Components along b and along g, where (g, b, z) are the axes x, y, z rotated about z.
  const T m_b = c * d_M.x() + s * d_M.y();
  const T m_g = s * d_M.x() - c * d_M.y();
  const T u_y = (m_b - c * d_F.x()) / s;
  const T u_g = (d_F.x() - c * m_b) / s;
  // h2 = 1 - u_x^2 - u_y^2, in a form without cancellation near the axis on the neighbor.
  const T h2 =
      rod_in_M ? T(d_F.y() * d_F.y() + d_F.z() * d_F.z() - u_y * u_y) : T(m_g * m_g + d_M.z() * d_M.z() - u_g * u_g);
  const auto solution = [&](const T& z, T* out) {
    out[0] = atan2(d_F.z(), d_F.y()) - atan2(z, u_y);
    out[1] = atan2(u_g, z) - atan2(m_g, d_M.z());
  };
  const double previous[] = {value_of(q[0]), value_of(q[1])};
  const double previous_z = rod_in_M
                                ? std::cos(previous[1]) * value_of(d_M.z()) - std::sin(previous[1]) * value_of(m_g)
                                : std::cos(previous[0]) * value_of(d_F.z()) - std::sin(previous[0]) * value_of(d_F.y());
  const T h = h2 > T(0) ? T(sqrt(h2)) : T(0);
  const T same_sign_z = std::signbit(previous_z) ? T(-h) : h;
  const int about_neighbor = rod_in_M ? 0 : 1;
  T crossed[2];
  solution(-same_sign_z, crossed);
  const double change =
      std::remainder(value_of(crossed[about_neighbor]) - previous[about_neighbor], 2 * std::numbers::pi);
  if (std::abs(change) < crossing_tolerance) {
    std::copy_n(crossed, 2, q);
  } else {
    solution(same_sign_z, q);
  }
}

// The same for a joint from the neighbor P to the rod R: X(q) e_R = e_P.
template <class J, class T>
void aim_outwards(const J& joint, const Vector3<T>& e_R, const Vector3<T>& e_P, T* q) {
  aim(joint, true, e_R, e_P, q);
}
template <class J, class T>
void aim_outwards(const Reversed<J>& joint, const Vector3<T>& e_R, const Vector3<T>& e_P, T* q) {
  aim(static_cast<const J&>(joint), false, e_P, e_R, q);
}

// Unit vector to the origin of the pose.
template <class T>
Vector3<T> direction(const typename SpatialAlgebra<T>::Pose& X) {
  return X.p / X.p.norm();
}
template <class T>
Vector3<T> direction(const typename PlanarAlgebra<T>::Pose& X) {
  const Vector3<T> p(X.px, X.py, T(0));
  return p / p.norm();
}

// Returns the angular velocity of the rod relative to the neighbor at its first joint if its far end, at d from this
// joint, moves with V: d x v / |d|^2, plus the component along d that the joint requires. All in the rod's frame.
template <class A, class J>
typename A::Motion angular_velocity(const J& first, const typename A::Scalar* q, const Eigen::Vector3d& d,
                                    const typename A::Motion& V) {
  using T = typename A::Scalar;
  typename A::Motion out;
  if constexpr (A::planar) {
    out.w = (d.x() * V.y - d.y() * V.x) / d.head<2>().squaredNorm();
  } else {
    const Vector3<T> e = d.normalized().cast<T>();
    Vector3<T> n;  // the angular velocity has no component along it
    if constexpr (J::nv == 2) {
      const T about_a[] = {T(1), T(0)};
      const T about_b[] = {T(0), T(1)};
      n = first.template V_FM<A>(q, about_a).w.cross(first.template V_FM<A>(q, about_b).w);
    } else {
      // Shortest rotation from the reference direction of e to e: no component along the sum of both.
      n = first.template X_FM<A>(q).R.transpose() * e + e;
    }
    out.w = e.cross(V.v) / T(d.norm());
    const T along = n.dot(e);
    if (along != T(0)) out.w -= n.dot(out.w) / along * e;
  }
  return out;
}

inline int nq_of(const Rod::End& end) {
  return std::visit([](const auto& joint) { return joint.nq; }, end);
}
inline int nv_of(const Rod::End& end) {
  return std::visit([](const auto& joint) { return joint.nv; }, end);
}

template <class A>
typename A::Pose pose_of(const Rod::End& end, Rod::In<A> q) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template X_FM<A>(q); });
}
template <class A>
typename A::Motion velocity_of(const Rod::End& end, Rod::In<A> q, Rod::In<A> v) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template V_FM<A>(q, v); });
}
template <class A>
typename A::Motion bias_of(const Rod::End& end, Rod::In<A> q, Rod::In<A> v) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template bias<A>(q, v); });
}

}  // namespace rods

template <class A>
typename A::Pose Rod::rod_pose(In<A> q) const {
  return rods::pose_of<A>(first, q);
}

template <class A>
typename A::Motion Rod::rod_velocity(In<A> q, In<A> v) const {
  return rods::velocity_of<A>(first, q, v);
}

template <class A>
typename A::Pose Rod::X_FM(In<A> q) const {
  return rods::pose_of<A>(first, q) * pose_in<A>(X_12) * rods::pose_of<A>(second, q + first_nq());
}

template <class A>
typename A::Motion Rod::V_FM(In<A> q, In<A> v) const {
  const typename A::Scalar* q_2 = q + first_nq();
  const typename A::Motion far = pose_in<A>(X_12).to_child(rods::velocity_of<A>(first, q, v));
  return rods::pose_of<A>(second, q_2).to_child(far) + rods::velocity_of<A>(second, q_2, v + first_nv());
}

template <class A>
typename A::Motion Rod::bias(In<A> q, In<A> v) const {
  const typename A::Scalar* q_2 = q + first_nq();
  const typename A::Scalar* v_2 = v + first_nv();
  const auto outwards = [&](const typename A::Motion& V) {
    return rods::pose_of<A>(second, q_2).to_child(pose_in<A>(X_12).to_child(V));
  };
  return outwards(rods::bias_of<A>(first, q, v)) +
         A::cross(outwards(rods::velocity_of<A>(first, q, v)), rods::velocity_of<A>(second, q_2, v_2)) +
         rods::bias_of<A>(second, q_2, v_2);
}

// F = S x with S^T S x = tau.
template <class A>
typename A::Force Rod::wrench_from_tau(In<A> q, In<A> tau) const {
  using T = typename A::Scalar;
  const int n = nv();
  typename A::Force column[max_nv];
  T gram[max_nv][max_nv];
  T x[max_nv];
  for (int k = 0; k < n; ++k) {
    T unit[max_nv] = {T(0), T(0), T(0), T(0), T(0), T(0)};
    unit[k] = T(1);
    const typename A::Motion V = V_FM<A>(q, unit);
    column[k] = as_force<A>(V);
    for (int i = 0; i <= k; ++i) gram[i][k] = gram[k][i] = A::dot(V, column[i]);
    x[k] = tau[k];
  }
  // Elimination without pivoting: the matrix is symmetric and positive definite.
  for (int k = 0; k < n; ++k) {
    for (int i = k + 1; i < n; ++i) {
      const T factor = gram[i][k] / gram[k][k];
      for (int j = k; j < n; ++j) gram[i][j] -= factor * gram[k][j];
      x[i] -= factor * x[k];
    }
  }
  typename A::Force F{};
  for (int k = n - 1; k >= 0; --k) {
    for (int j = k + 1; j < n; ++j) x[k] -= gram[k][j] * x[j];
    x[k] /= gram[k][k];
    F += x[k] * column[k];
  }
  return F;
}

template <class A>
void Rod::speeds(In<A> q, const typename A::Motion& V, Out<A> v) const {
  const typename A::Scalar* q_2 = q + first_nq();
  const typename A::Pose X_2 = rods::pose_of<A>(second, q_2);
  const typename A::Pose on_rod = pose_in<A>(X_12);
  typename A::Pose turn = on_rod;
  if constexpr (A::planar) {
    turn.px = turn.py = 0;
  } else {
    turn.p.setZero();
  }
  const typename A::Motion far = X_2.to_parent(V);  // velocity of M at the second joint, in the axes of the rod
  rods::visit_end<A>(first, [&](const auto& joint) {
    const typename A::Motion of_rod = rods::angular_velocity<A>(joint, q, X_12.p, turn.to_parent(far));
    joint.template speeds<A>(q, of_rod, v);
    const typename A::Motion rest = X_2.to_child(far - on_rod.to_child(of_rod));
    rods::visit_end<A>(second, [&](const auto& other) { other.template speeds<A>(q_2, rest, v + joint.nv); });
  });
}

template <class A>
void Rod::coordinates(const typename A::Pose& X_FM, Out<A> q) const {
  using T = typename A::Scalar;
  const Vector3<T> e_R = X_12.p.normalized().cast<T>();
  rods::visit_end<A>(first, [&](const auto& joint) { rods::aim_outwards(joint, e_R, rods::direction<T>(X_FM), q); });
  const typename A::Pose X_2 = (rods::pose_of<A>(first, q) * pose_in<A>(X_12)).inverse() * X_FM;
  rods::visit_end<A>(second, [&](const auto& joint) { joint.template coordinates<A>(X_2, q + first_nq()); });
}

#define GELENK_INSTANTIATE(A)                                          \
  template A::Pose Rod::rod_pose<A>(In<A>) const;                      \
  template A::Motion Rod::rod_velocity<A>(In<A>, In<A>) const;         \
  template A::Pose Rod::X_FM<A>(In<A>) const;                          \
  template A::Motion Rod::V_FM<A>(In<A>, In<A>) const;                 \
  template A::Motion Rod::bias<A>(In<A>, In<A>) const;                 \
  template A::Force Rod::wrench_from_tau<A>(In<A>, In<A>) const;       \
  template void Rod::speeds<A>(In<A>, const A::Motion&, Out<A>) const; \
  template void Rod::coordinates<A>(const A::Pose&, Out<A>) const;

}  // namespace gelenk
