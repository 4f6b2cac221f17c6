// SPDX-License-Identifier: BSD-3-Clause
// Values of surfaces for any number type.
#pragma once

#include <array>
#include <cstddef>

#include "element/constraints/surface_law.h"

namespace gelenk {

template <class T, std::size_t n>
std::array<T, n> values_of_tape(const expression::Tape& tape, const Vector3<T>& p, double length) {
  const Vector3<T> in_si = p * T(length);
  std::array<T, n> out;
  tape.evaluate(in_si.data(), out.data());
  return out;
}

template <class T>
SurfaceLaw::Place<T> SurfaceLaw::place(const Vector3<T>& p) const {
  const std::array<T, 4> of = values_of_tape<T, 4>(first_, p, length_);
  const Vector3<T> gradient(of[1], of[2], of[3]);
  const T size = gradient.norm();
  return {of[0] / (size * T(length_)), gradient / size};
}

template <class T>
SurfaceLaw::Bend<T> SurfaceLaw::bend(const Vector3<T>& p) const {
  const std::array<T, 9> of = values_of_tape<T, 9>(second_, p, length_);
  Bend<T> out{.gradient = {of[0], of[1], of[2]}, .hessian = {}};
  out.hessian << of[3], of[4], of[5], of[4], of[6], of[7], of[5], of[7], of[8];
  out.hessian *= T(length_);
  return out;
}

template <class T>
Vector3<T> SurfaceLaw::normal_rate(const Vector3<T>& p, const Vector3<T>& v) const {
  const Bend<T> at = bend(p);
  const T size = at.gradient.norm();
  const Vector3<T> normal = at.gradient / size;
  const Vector3<T> change = at.hessian * v / size;
  return change - normal * normal.dot(change);
}

}  // namespace gelenk
