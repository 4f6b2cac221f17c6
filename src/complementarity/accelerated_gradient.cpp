// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/accelerated_gradient.h"

#include <cmath>
#include <limits>

#include "complementarity/shift.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr Index large = 3000;  // unknowns, beyond which residuals are looked at once in an interval
constexpr int interval = 5;
constexpr double curvature_decay = 0.9;  // per iteration, of the estimate of G's largest eigenvalue

// A first estimate of the largest eigenvalue, along the gradient.
double estimate(ConeIteration& at, const ConeVector& shift, ConeVector& gradient, ConeVector& G_gradient) {
  gradient = at.u() + shift;
  at.multiply(gradient.data(), G_gradient.data());
  const double found = gradient.dot(G_gradient) / gradient.squaredNorm();
  return found > 0 && std::isfinite(found) ? found : 1;
}

// next <- P_K(y - (uy + shift) / curvature), with a curvature that bounds that of the objective along the step. Returns
// the curvature to be tried next.
double step(ConeIteration& at, const ConeVector& shift, const ConeVector& y, const ConeVector& uy, ConeVector& next,
            ConeVector& next_u, double curvature) {
  constexpr int doublings = 60;
  for (int k = 0;; ++k) {
    next = y - (uy + shift) / curvature;
    at.project_all(next.data(), next.data());
    at.multiply(next.data(), next_u.data());
    next_u += at.b();
    const double along = (next - y).dot(next_u - uy);
    if (!(along > curvature * (next - y).squaredNorm()) || k == doublings) return curvature_decay * curvature;
    curvature *= 2;
  }
}

}  // namespace

void AcceleratedGradient::run(ConeIteration& at, int max_steps) {
  const Index n = at.size();
  reserve(n);
  ConeVector shift = memory_.vector(n), y = memory_.vector(n), uy = memory_.vector(n);
  ConeVector next = memory_.vector(n), next_u = memory_.vector(n), last = memory_.vector(n), last_u = memory_.vector(n);
  FrozenShift frozen(at, shift.data(), next.data());
  double curvature = estimate(at, shift, next, next_u);
  double t = 1;
  last = at.x();
  last_u = at.u();
  for (int k = 0; k < max_steps; ++k) {
    const double t_next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
    const double momentum = (t - 1) / t_next;
    y = at.x() + momentum * (at.x() - last);
    uy = at.u() + momentum * (at.u() - last_u);
    curvature = step(at, shift, y, uy, next, next_u, curvature);
    const bool ascends = (uy + shift).dot(next - at.x()) > 0;
    t = ascends ? 1 : t_next;
    last = at.x();
    last_u = at.u();
    at.x() = next;
    at.u() = next_u;
    const bool look = n <= large || (k + 1) % interval == 0;
    if (!at.advance(look)) return;
    if (look && frozen.renew_if_solved()) t = 1;
  }
}

namespace {

class AcceleratedSolver final : public IterativeConeSolver {
  void reserve(ConeIteration& at) override { method_.reserve(at.size()); }
  void run(ConeIteration& at) override { method_.run(at, std::numeric_limits<int>::max()); }
  AcceleratedGradient method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_accelerated_cone_solver() { return std::make_unique<AcceleratedSolver>(); }

}  // namespace gelenk
