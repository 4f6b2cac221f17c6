// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/surface_law_impl.h"

#include <cmath>

#include "math/dual.h"
#include "math/series.h"

namespace gelenk {
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

bool SurfaceLaw::has_normal(const Eigen::Vector3d& p) const {
  constexpr double least_radius = 1e-6;
  const Bend<double> at = bend(p);
  const double size = at.gradient.norm();
  return std::isfinite(size) && size > 0 && !(size < least_radius * at.hessian.norm());
}

template SurfaceLaw::Place<double> SurfaceLaw::place(const Vector3<double>&) const;
template SurfaceLaw::Place<Dual> SurfaceLaw::place(const Vector3<Dual>&) const;
template SurfaceLaw::Place<Series> SurfaceLaw::place(const Vector3<Series>&) const;
template Vector3<double> SurfaceLaw::normal_rate(const Vector3<double>&, const Vector3<double>&) const;
template Vector3<Dual> SurfaceLaw::normal_rate(const Vector3<Dual>&, const Vector3<Dual>&) const;
template Vector3<Series> SurfaceLaw::normal_rate(const Vector3<Series>&, const Vector3<Series>&) const;

}  // namespace gelenk
