// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/distributed_forces.h"

#include <limits>
#include <utility>

#include "linear/least_load.h"

namespace gelenk {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

void set_holding_bounds(const SwitchingForces& forces, const std::vector<int>& locks, const std::vector<int>& contacts,
                        HoldingBounds& out) {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  const auto n = static_cast<Index>(locks.size());
  out.lower.resize(n);
  out.upper.resize(n);
  for (Index i = 0; i < n; ++i) {
    const int lock = locks[static_cast<std::size_t>(i)];
    const DirectedLimit limit = forces.sticking_limit(lock);
    const int side = contacts[static_cast<std::size_t>(lock)];
    const bool is_latched = forces.hold_coordinate(lock);
    out.lower[i] = side > 0 || is_latched ? -unlimited : -limit.against(1);
    out.upper[i] = side < 0 || is_latched ? unlimited : limit.against(-1);
  }
}

bool are_same(const VectorXd& a, const VectorXd& b) { return a.size() == b.size() && a == b; }

}  // namespace

HoldingBounds holding_bounds(const SwitchingForces& forces, const std::vector<int>& locks,
                             const std::vector<int>& contacts) {
  HoldingBounds out;
  set_holding_bounds(forces, locks, contacts, out);
  return out;
}

const VectorXd& DistributedForces::find(SwitchingForces& forces, const std::vector<int>& locks,
                                        const std::vector<int>& contacts) {
  x_now_.resize(static_cast<Index>(locks.size()));
  for (Index i = 0; i < x_now_.size(); ++i)
    x_now_[i] = forces.holding_forces().values()[static_cast<std::size_t>(locks[static_cast<std::size_t>(i)])];
  if (!forces.is_redundant()) return x_now_;
  set_holding_bounds(forces, locks, contacts, bounds_now_);
  forces.compliance(locks, W_now_, scale_);
  b_now_.noalias() = W_now_ * x_now_;
  if (are_same(b_now_, b_) && W_now_ == W_ && bounds_now_.lower == bounds_.lower && bounds_now_.upper == bounds_.upper)
    return x_;
  std::swap(W_, W_now_);
  std::swap(b_, b_now_);
  std::swap(bounds_, bounds_now_);
  least_load(W_, b_, bounds_.lower, bounds_.upper, x_);
  return x_;
}

}  // namespace gelenk
