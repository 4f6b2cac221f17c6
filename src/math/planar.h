// SPDX-License-Identifier: BSD-3-Clause
// Planar algebra: the counterpart of spatial.h with 3-vectors, for mechanisms that move in a plane:
// motions (w | vx, vy), forces (n | fx, fy). The plane's normal is the common z axis. Units as in spatial.h.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gelenk {

template <class T>
struct PlanarAlgebra {
  using Scalar = T;
  static constexpr bool planar = true;
  static constexpr int dimension = 3;

  struct Motion {
    T w{0};
    T x{0};
    T y{0};

    Motion& operator+=(const Motion& b) {
      w += b.w;
      x += b.x;
      y += b.y;
      return *this;
    }
    friend Motion operator+(Motion a, const Motion& b) { return a += b; }
    friend Motion operator-(const Motion& a, const Motion& b) { return {a.w - b.w, a.x - b.x, a.y - b.y}; }
    friend Motion operator*(const T& s, const Motion& a) { return {s * a.w, s * a.x, s * a.y}; }
  };

  struct Force {
    T n{0};
    T x{0};
    T y{0};

    Force& operator+=(const Force& b) {
      n += b.n;
      x += b.x;
      y += b.y;
      return *this;
    }
    Force& operator-=(const Force& b) {
      n -= b.n;
      x -= b.x;
      y -= b.y;
      return *this;
    }
    friend Force operator+(Force a, const Force& b) { return a += b; }
    friend Force operator-(Force a, const Force& b) { return a -= b; }
    friend Force operator*(const T& s, const Force& a) { return {s * a.n, s * a.x, s * a.y}; }
  };

  // X_AB: pose of frame B in frame A. The axes of B are those of A rotated by the angle with cosine c and sine s; p is
  // the origin of B in A.
  struct Pose {
    T c{1};
    T s{0};
    T px{0};
    T py{0};

    friend Pose operator*(const Pose& a, const Pose& b) {
      return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s, a.px + a.c * b.px - a.s * b.py,
              a.py + a.s * b.px + a.c * b.py};
    }
    Pose inverse() const { return {c, -s, -(c * px + s * py), s * px - c * py}; }

    Motion to_child(const Motion& V) const {
      const T x = V.x - V.w * py;
      const T y = V.y + V.w * px;
      return {V.w, c * x + s * y, c * y - s * x};
    }
    Motion to_parent(const Motion& V) const {
      return {V.w, c * V.x - s * V.y + V.w * py, s * V.x + c * V.y - V.w * px};
    }
    Force to_parent(const Force& F) const {
      const T x = c * F.x - s * F.y;
      const T y = s * F.x + c * F.y;
      return {F.n + px * y - py * x, x, y};
    }
    Force to_child(const Force& F) const { return {F.n - px * F.y + py * F.x, c * F.x + s * F.y, c * F.y - s * F.x}; }
  };

  // Mass [kg], first moment [kg m] and polar second moment about the origin [kg m2].
  struct Inertia {
    T m{0};
    T hx{0};
    T hy{0};
    T I{0};

    Inertia& operator+=(const Inertia& b) {
      m += b.m;
      hx += b.hx;
      hy += b.hy;
      I += b.I;
      return *this;
    }
    Force operator*(const Motion& V) const {
      return {I * V.w + hx * V.y - hy * V.x, m * V.x - hy * V.w, m * V.y + hx * V.w};
    }
    Inertia moved_by(const Pose& X) const {
      const T x = X.c * hx - X.s * hy;
      const T y = X.s * hx + X.c * hy;
      return {m, x + m * X.px, y + m * X.py, I + T(2) * (X.px * x + X.py * y) + m * (X.px * X.px + X.py * X.py)};
    }
  };

  // Articulated-body inertia: any symmetric 3x3 matrix (Featherstone 2008, sec. 7.1).
  struct ArticulatedInertia {
    T nw{0};         // torque per angular acceleration
    T xw{0}, yw{0};  // forces per angular acceleration; torques per acceleration along x, y
    T xx{0}, xy{0}, yy{0};

    ArticulatedInertia() = default;
    explicit ArticulatedInertia(const Inertia& G) : nw(G.I), xw(-G.hy), yw(G.hx), xx(G.m), xy(0), yy(G.m) {}
    Force operator*(const Motion& V) const {
      return {nw * V.w + xw * V.x + yw * V.y, xw * V.w + xx * V.x + xy * V.y, yw * V.w + xy * V.x + yy * V.y};
    }
    // Subtracts U (s U)^T.
    void subtract(const Force& U, const T& s) {
      const T n = s * U.n;
      const T x = s * U.x;
      const T y = s * U.y;
      nw -= n * U.n;
      xw -= n * U.x;
      yw -= n * U.y;
      xx -= x * U.x;
      xy -= x * U.y;
      yy -= y * U.y;
    }
    // Adds b, given about the origin of B in the axes of B, after transformation to A (X = X_AB).
    void add_moved(const ArticulatedInertia& b, const Pose& X) {
      const T tx = -X.py;
      const T ty = X.px;
      const T ax = X.c * b.xw - X.s * b.yw;
      const T ay = X.s * b.xw + X.c * b.yw;
      const T cc = X.c * X.c;
      const T ss = X.s * X.s;
      const T cs = X.c * X.s;
      const T Bxx = cc * b.xx - T(2) * cs * b.xy + ss * b.yy;
      const T Byy = ss * b.xx + T(2) * cs * b.xy + cc * b.yy;
      const T Bxy = cs * (b.xx - b.yy) + (cc - ss) * b.xy;
      const T mx = ax + Bxx * tx + Bxy * ty;
      const T my = ay + Bxy * tx + Byy * ty;
      nw += b.nw + tx * (ax + mx) + ty * (ay + my);
      xw += mx;
      yw += my;
      xx += Bxx;
      xy += Bxy;
      yy += Byy;
    }
  };

  static T dot(const Motion& V, const Force& F) { return V.w * F.n + V.x * F.x + V.y * F.y; }
  static Motion cross(const Motion& V, const Motion& A) { return {T(0), V.y * A.w - V.w * A.y, V.w * A.x - V.x * A.w}; }
  static Force cross_force(const Motion& V, const Force& F) { return {V.x * F.y - V.y * F.x, -V.w * F.y, V.w * F.x}; }
};

using Planar = PlanarAlgebra<double>;

}  // namespace gelenk
