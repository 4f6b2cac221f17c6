// SPDX-License-Identifier: BSD-3-Clause
// The forces with which friction and limits keep coordinates at rest, by lock (switching_forces.h), in the user's
// signs.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace gelenk {

class HoldingForces {
 public:
  // signs: by lock, user's speed over the mechanism's.
  explicit HoldingForces(std::vector<double> signs)
      : signs_(std::move(signs)), x_(signs_.size()), redistribution_(signs_.size()) {}

  // Those of the last solve(); 0 for others. Where several are redundant, those of least norm.
  const std::vector<double>& values() const { return x_; }
  // Sets them from the mechanism's signs.
  void set(const std::vector<double>& x) {
    in_users_signs(x, x_.data());
    is_redistributed_ = false;
  }
  // Adds those of other forces.
  void add(const std::vector<double>& x) {
    for (std::size_t i = 0; i < x.size(); ++i) x_[i] += x[i];
  }
  // Replaces them by others with the same effect; constraint forces follow.
  void redistribute(const std::vector<double>& x) {
    find_difference(x, redistribution_);
    x_ = x;
    is_redistributed_ = true;
  }
  // out: by how much x differs from those of the last solve(), in the mechanism's signs.
  void find_difference(const std::vector<double>& x, std::vector<double>& out) const {
    for (std::size_t i = 0; i < x.size(); ++i) {
      out[i] = (is_redistributed_ ? redistribution_[i] : 0) + signs_[i] * (x[i] - x_[i]);
    }
  }
  // The same of the present ones; null: not at all.
  const double* redistribution() const { return is_redistributed_ ? redistribution_.data() : nullptr; }

  void in_users_signs(const std::vector<double>& x, double* out) const {
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = signs_[i] * x[i];
  }

 private:
  std::vector<double> signs_, x_, redistribution_;
  bool is_redistributed_ = false;
};

}  // namespace gelenk
