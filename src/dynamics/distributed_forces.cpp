// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/distributed_forces.h"

#include <limits>

#include "linear/least_load.h"

namespace gelenk {

using Eigen::Index;
using Eigen::VectorXd;

HoldingBounds holding_bounds(const SwitchingForces& forces, const std::vector<int>& locks,
                             const std::vector<int>& contacts) {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  const auto n = static_cast<Index>(locks.size());
  HoldingBounds out{VectorXd(n), VectorXd(n)};
  for (Index i = 0; i < n; ++i) {
    const int lock = locks[static_cast<std::size_t>(i)];
    const DirectedLimit limit = forces.lock(lock).sticking_limit;
    const int side = contacts[static_cast<std::size_t>(lock)];
    out.lower[i] = side > 0 ? -unlimited : -limit.against(1);
    out.upper[i] = side < 0 ? unlimited : limit.against(-1);
  }
  return out;
}

VectorXd distributed_forces(SwitchingForces& forces, const std::vector<int>& locks, const HoldingBounds& bounds) {
  VectorXd x(static_cast<Index>(locks.size()));
  for (Index i = 0; i < x.size(); ++i)
    x[i] = forces.holding_forces().values()[static_cast<std::size_t>(locks[static_cast<std::size_t>(i)])];
  if (!forces.is_redundant()) return x;
  Eigen::MatrixXd W;
  VectorXd scale;
  forces.compliance(locks, W, scale);
  return least_load(W, W * x, bounds.lower, bounds.upper);
}

}  // namespace gelenk
