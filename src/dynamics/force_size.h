// SPDX-License-Identifier: BSD-3-Clause
// An estimate of the forces to which the rounding of accelerations and holding forces is relative, |L^-T f| with M =
// L^T L: the generalized forces f of an evaluation, and weights and forces of inertia, which may cancel in them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "dynamics/mass_factor.h"
#include "kinematics/loads.h"

namespace gelenk {

// Found when it is asked for, since most evaluations need none.
template <class A>
class ForceSize {
 public:
  // All must outlive it. v: the present velocities.
  ForceSize(const Model<A>& model, const Loads& loads, const std::vector<double>& v, const MassFactor<A>& M)
      : loads_(loads), v_(v), M_(M), f_(v.size()) {
    double mass = 0;
    for (const auto& link : model.links) mass += link.G.m;
    sqrt_mass_ = std::sqrt(mass);
  }

  // The generalized forces of an evaluation.
  void set(const std::vector<double>& f) {
    f_ = f;
    size_ = -1;
  }
  // With the factors of that evaluation.
  double value() const {
    if (size_ >= 0) return size_;
    const auto n = static_cast<Eigen::Index>(v_.size());
    const Eigen::Map<const Eigen::VectorXd> v(v_.data(), n);
    Eigen::Map<Eigen::VectorXd> w(f_.data(), n);
    M_.solve_transposed(w.data());
    size_ = w.norm() + sqrt_mass_ * loads_.gravity.norm();
    M_.multiply(v.data(), w.data());
    size_ += w.norm() * v.cwiseAbs().maxCoeff();
    if (!std::isfinite(size_)) size_ = 0;  // forces too large for numbers: what is beyond its law is no rounding
    return size_;
  }

 private:
  const Loads& loads_;
  const std::vector<double>& v_;
  const MassFactor<A>& M_;
  double sqrt_mass_ = 0;           // of the whole mechanism
  mutable std::vector<double> f_;  // overwritten when the size is found
  mutable double size_ = 0;        // -1: not yet found
};

}  // namespace gelenk
