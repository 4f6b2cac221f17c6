// SPDX-License-Identifier: BSD-3-Clause
// A surface g(x, y, z) = 0 and its derivatives, by an expression for g. T: double, Dual or Series.
#pragma once

#include <vector>

#include "expression/tape.h"
#include "field/formula.h"
#include "math/spatial.h"

namespace gelenk {

class SurfaceLaw {
 public:
  SurfaceLaw() = default;  // not to be evaluated
  // Throws std::length_error if the derivatives have too many terms.
  explicit SurfaceLaw(const Formula& g);

  // Distance from the surface to first order, g/|grad g|, in the unit of p, and the unit normal grad g/|grad g|.
  template <class T>
  struct Place {
    T distance;
    Vector3<T> normal;
  };
  template <class T>
  Place<T> place(const Vector3<T>& p) const;
  // Whether the gradient is finite, and so large that the surface bends by radii above a millionth of the unit.
  bool has_normal(const Eigen::Vector3d& p) const;
  // The rate of the normal at a point that moves with v.
  template <class T>
  Vector3<T> normal_rate(const Vector3<T>& p, const Vector3<T>& v) const;

 private:
  // The gradient and the Hessian matrix times the unit of length, at p.
  template <class T>
  struct Bend {
    Vector3<T> gradient;
    Matrix3<T> hessian;
  };
  template <class T>
  Bend<T> bend(const Vector3<T>& p) const;

  expression::Tape first_, second_;  // g and its gradient; the gradient and the Hessian matrix, its upper triangle
  double length_ = 1;                // m: unit of positions
};

}  // namespace gelenk
