// SPDX-License-Identifier: BSD-3-Clause
// Spatial algebra: rigid-body motions, forces and inertias in space as 6-vectors
// (Featherstone 2008, chapter 2), angular part first.
//
// T is the number type: double, Dual (dual.h) or Series (series.h).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace gelenk {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

// The matrix K with K b = a x b.
template <class T>
Matrix3<T> cross_matrix(const Vector3<T>& a) {
  Matrix3<T> K;
  K << T(0), -a.z(), a.y(), a.z(), T(0), -a.x(), -a.y(), a.x(), T(0);
  return K;
}

template <class T>
struct SpatialAlgebra {
  using Scalar = T;
  static constexpr bool planar = false;
  static constexpr int dimension = 6;

  // Velocity or acceleration: angular [rad/s, rad/s2], linear [m/s, m/s2] of the frame's origin.
  struct Motion {
    Vector3<T> w{Vector3<T>::Zero()};
    Vector3<T> v{Vector3<T>::Zero()};

    Motion& operator+=(const Motion& b) {
      w += b.w;
      v += b.v;
      return *this;
    }
    friend Motion operator+(Motion a, const Motion& b) { return a += b; }
    friend Motion operator-(const Motion& a, const Motion& b) { return {a.w - b.w, a.v - b.v}; }
    friend Motion operator*(const T& s, const Motion& a) { return {s * a.w, s * a.v}; }
  };

  // Torque about the frame's origin [N m] and force [N].
  struct Force {
    Vector3<T> n{Vector3<T>::Zero()};
    Vector3<T> f{Vector3<T>::Zero()};

    Force& operator+=(const Force& b) {
      n += b.n;
      f += b.f;
      return *this;
    }
    Force& operator-=(const Force& b) {
      n -= b.n;
      f -= b.f;
      return *this;
    }
    friend Force operator+(Force a, const Force& b) { return a += b; }
    friend Force operator-(Force a, const Force& b) { return a -= b; }
    friend Force operator*(const T& s, const Force& a) { return {s * a.n, s * a.f}; }
  };

  // X_AB: pose of frame B in frame A; R's columns are B's axes written in A.
  struct Pose {
    Matrix3<T> R{Matrix3<T>::Identity()};
    Vector3<T> p{Vector3<T>::Zero()};

    friend Pose operator*(const Pose& X_AB, const Pose& X_BC) { return {X_AB.R * X_BC.R, X_AB.p + X_AB.R * X_BC.p}; }
    Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
    Vector3<T> point(const Vector3<T>& p_B) const { return p + R * p_B; }

    // Transforms a motion of the rigid body to which A and B are fixed, from the origin and axes of A to those of B.
    Motion to_child(const Motion& V_A) const {
      return {R.transpose() * V_A.w, R.transpose() * (V_A.v + V_A.w.cross(p))};
    }
    // The inverse transformation.
    Motion to_parent(const Motion& V_B) const {
      const Vector3<T> w = R * V_B.w;
      return {w, R * V_B.v - w.cross(p)};
    }
    // Transforms a force from the origin and axes of B to those of A.
    Force to_parent(const Force& F_B) const {
      const Vector3<T> f = R * F_B.f;
      return {R * F_B.n + p.cross(f), f};
    }
    // The inverse transformation.
    Force to_child(const Force& F_A) const { return {R.transpose() * (F_A.n - p.cross(F_A.f)), R.transpose() * F_A.f}; }
  };

  // Rigid-body inertia about the frame's origin: mass [kg], first moment h = m c [kg m],
  // second moment I [kg m2] about the origin (not the center of mass).
  struct Inertia {
    T m{0};
    Vector3<T> h{Vector3<T>::Zero()};
    Matrix3<T> I{Matrix3<T>::Zero()};

    // Inertia of a body with mass m, center of mass c and inertia I_c about the center of mass, all in the same frame.
    static Inertia about_com(const T& m, const Vector3<T>& c, const Matrix3<T>& I_c) {
      return {m, m * c, I_c + m * (c.squaredNorm() * Matrix3<T>::Identity() - c * c.transpose())};
    }
    Inertia& operator+=(const Inertia& b) {
      m += b.m;
      h += b.h;
      I += b.I;
      return *this;
    }
    Force operator*(const Motion& V) const { return {I * V.w + h.cross(V.v), m * V.v - h.cross(V.w)}; }

    // Transforms the inertia from the origin and axes of B to those of A (X = X_AB). Flattened, since the linker keeps
    // any of the copies in the files that use it, and a copy that calls Eigen's assignments slows an arm down by 5 %.
    [[gnu::flatten]] Inertia moved_by(const Pose& X) const {
      const Vector3<T> Rh = X.R * h;
      const Vector3<T>& p = X.p;
      // I_A = R I R^T - [Rh]x[p]x - [p]x[Rh]x - m [p]x[p]x, written without the 3 matrix products.
      const T s = T(2) * p.dot(Rh) + m * p.squaredNorm();
      const Matrix3<T> outer = Rh * p.transpose() + p * (Rh + m * p).transpose();
      Matrix3<T> out = X.R * I * X.R.transpose() - outer;
      out.diagonal().array() += s;
      return {m, Rh + m * p, out};
    }
  };

  // Articulated-body inertia: any symmetric 6x6 matrix [I H; H^T M] (Featherstone 2008, sec. 7.1).
  struct ArticulatedInertia {
    Matrix3<T> I{Matrix3<T>::Zero()};
    Matrix3<T> H{Matrix3<T>::Zero()};
    Matrix3<T> M{Matrix3<T>::Zero()};

    ArticulatedInertia() = default;
    explicit ArticulatedInertia(const Inertia& G) : I(G.I), H(cross_matrix(G.h)), M(G.m * Matrix3<T>::Identity()) {}
    Force operator*(const Motion& V) const { return {I * V.w + H * V.v, H.transpose() * V.w + M * V.v}; }
    // Subtracts U (s U)^T.
    void subtract(const Force& U, const T& s) {
      const Vector3<T> n = s * U.n;
      const Vector3<T> f = s * U.f;
      I -= U.n * n.transpose();
      H -= U.n * f.transpose();
      M -= U.f * f.transpose();
    }
    // Adds b, given about the origin of B in the axes of B, after transformation to A (X = X_AB).
    void add_moved(const ArticulatedInertia& b, const Pose& X) {
      const Matrix3<T> P = cross_matrix(X.p);
      const Matrix3<T> M_A = X.R * b.M * X.R.transpose();
      const Matrix3<T> H_A = X.R * b.H * X.R.transpose();
      const Matrix3<T> H_moved = H_A + P * M_A;
      M += M_A;
      H += H_moved;
      I += X.R * b.I * X.R.transpose() - H_A * P + P * H_moved.transpose();
    }
  };

  static T dot(const Motion& V, const Force& F) { return V.w.dot(F.n) + V.v.dot(F.f); }
  // V x A, the rate of a motion vector fixed in a frame that moves with V (Featherstone 2008, eq. 2.31).
  static Motion cross(const Motion& V, const Motion& A) { return {V.w.cross(A.w), V.w.cross(A.v) + V.v.cross(A.w)}; }
  // V x* F, the rate of a force vector fixed in a frame that moves with V (Featherstone 2008, eq. 2.32).
  static Force cross_force(const Motion& V, const Force& F) {
    return {V.w.cross(F.n) + V.v.cross(F.f), V.w.cross(F.f)};
  }
};

using Spatial = SpatialAlgebra<double>;
using Pose3 = Spatial::Pose;

// Returns the shortest rotation that takes z to the unit vector n (half a turn about x for n = -z).
Eigen::Matrix3d rotation_taking_z_to(const Eigen::Vector3d& n);

// Returns the rotation vector of R: axis times angle in [0, pi].
template <class T>
Vector3<T> rotation_vector(const Matrix3<T>& R) {
  using std::atan2;
  Eigen::Quaternion<T> Q(R);
  if (Q.w() < T(0)) Q.coeffs() = -Q.coeffs();
  const Vector3<T> vec = Q.vec();
  const T s = vec.norm();
  // For small angles sin(x)/x is 1 to within rounding error; this avoids 0/0.
  if (s < T(1e-9)) return T(2) * vec;
  return (T(2) * atan2(s, Q.w()) / s) * vec;
}

}  // namespace gelenk
