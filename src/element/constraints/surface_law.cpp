// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/surface_law.h"

#include <array>
#include <cmath>

#include "math/dual.h"
#include "math/series.h"

namespace gelenk {
namespace {

template <class T, std::size_t n>
std::array<T, n> values(const expression::Tape& tape, const Vector3<T>& p, double length) {
  const Vector3<T> in_si = p * T(length);
  std::array<T, n> out;
  tape.evaluate(in_si.data(), out.data());
  return out;
}

}  // namespace

SurfaceLaw::SurfaceLaw(const Formula& g) : length_(g.size_of(0)) {
  expression::Graph graph = g.graph();
  std::vector<expression::Term> gradient;
  for (int i = 0; i < 3; ++i) gradient.push_back(derivative(graph, g.term(), i));
  std::vector<expression::Term> terms = {g.term()};
  terms.insert(terms.end(), gradient.begin(), gradient.end());
  first_ = expression::Tape(graph, terms);
  terms = gradient;
  for (int i = 0; i < 3; ++i) {
    for (int k = i; k < 3; ++k) terms.push_back(derivative(graph, gradient[static_cast<std::size_t>(i)], k));
  }
  second_ = expression::Tape(graph, terms);
}

template <class T>
SurfaceLaw::Place<T> SurfaceLaw::place(const Vector3<T>& p) const {
  const std::array<T, 4> of = values<T, 4>(first_, p, length_);
  const Vector3<T> gradient(of[1], of[2], of[3]);
  const T size = gradient.norm();
  return {of[0] / (size * T(length_)), gradient / size};
}

template <class T>
SurfaceLaw::Bend<T> SurfaceLaw::bend(const Vector3<T>& p) const {
  const std::array<T, 9> of = values<T, 9>(second_, p, length_);
  Bend<T> out{.gradient = {of[0], of[1], of[2]}, .hessian = {}};
  out.hessian << of[3], of[4], of[5], of[4], of[6], of[7], of[5], of[7], of[8];
  out.hessian *= T(length_);
  return out;
}

bool SurfaceLaw::has_normal(const Eigen::Vector3d& p) const {
  constexpr double least_radius = 1e-6;
  const Bend<double> at = bend(p);
  const double size = at.gradient.norm();
  return std::isfinite(size) && size > 0 && !(size < least_radius * at.hessian.norm());
}

template <class T>
Vector3<T> SurfaceLaw::normal_rate(const Vector3<T>& p, const Vector3<T>& v) const {
  const Bend<T> at = bend(p);
  const T size = at.gradient.norm();
  const Vector3<T> normal = at.gradient / size;
  const Vector3<T> change = at.hessian * v / size;
  return change - normal * normal.dot(change);
}

template SurfaceLaw::Place<double> SurfaceLaw::place(const Vector3<double>&) const;
template SurfaceLaw::Place<Dual> SurfaceLaw::place(const Vector3<Dual>&) const;
template SurfaceLaw::Place<Series> SurfaceLaw::place(const Vector3<Series>&) const;
template Vector3<double> SurfaceLaw::normal_rate(const Vector3<double>&, const Vector3<double>&) const;
template Vector3<Dual> SurfaceLaw::normal_rate(const Vector3<Dual>&, const Vector3<Dual>&) const;
template Vector3<Series> SurfaceLaw::normal_rate(const Vector3<Series>&, const Vector3<Series>&) const;

}  // namespace gelenk
