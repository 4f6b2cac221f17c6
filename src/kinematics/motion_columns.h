// SPDX-License-Identifier: BSD-3-Clause
// Motions of many velocities, stored component by component, for vectorized scalar products with a force.
#pragma once

#include <vector>

#include "math/planar.h"
#include "math/spatial.h"

namespace gelenk {

inline void unpack(const Spatial::Motion& V, double* x) {
  Eigen::Map<Eigen::Vector3d>{x} = V.w;
  Eigen::Map<Eigen::Vector3d>{x + 3} = V.v;
}
inline void unpack(const Spatial::Force& F, double* x) {
  Eigen::Map<Eigen::Vector3d>{x} = F.n;
  Eigen::Map<Eigen::Vector3d>{x + 3} = F.f;
}
inline void unpack(const Planar::Motion& V, double* x) { x[0] = V.w, x[1] = V.x, x[2] = V.y; }
inline void unpack(const Planar::Force& F, double* x) { x[0] = F.n, x[1] = F.x, x[2] = F.y; }

inline void pack(const double* x, Spatial::Force& F) {
  F.n = Eigen::Map<const Eigen::Vector3d>(x);
  F.f = Eigen::Map<const Eigen::Vector3d>(x + 3);
}
inline void pack(const double* x, Planar::Force& F) { F = {x[0], x[1], x[2]}; }

// Velocities [first, last).
struct IndexRange {
  int first, last;
};

template <class A>
class MotionColumns {
 public:
  explicit MotionColumns(int speeds) : stride_(speeds), x_(static_cast<std::size_t>(A::dimension) * speeds) {}

  void set(int k, const typename A::Motion& V) {
    double x[A::dimension];
    unpack(V, x);
    for (int c = 0; c < A::dimension; ++c) x_[static_cast<std::size_t>(c) * stride_ + k] = x[c];
  }
  const double* component(int c) const { return x_.data() + static_cast<std::size_t>(c) * stride_; }
  int stride() const { return stride_; }

  // out[k] += sign F . V_k, k in the range.
  void add_dots(const typename A::Force& F, double sign, IndexRange range, double* __restrict out) const {
    double f[A::dimension];
    unpack(F, f);
    for (double& x : f) x *= sign;
    const double* __restrict x = x_.data();
    for (int k = range.first; k < range.last; ++k) {
      double sum = out[k];
      for (int c = 0; c < A::dimension; ++c) sum += f[c] * x[static_cast<std::size_t>(c) * stride_ + k];
      out[k] = sum;
    }
  }

 private:
  int stride_;
  std::vector<double> x_;
};

}  // namespace gelenk
