// SPDX-License-Identifier: BSD-3-Clause
#include "modes/impact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "linear/box_complementarity.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double unlimited = std::numeric_limits<double>::infinity();

// Of the terms of the energy of an impact.
constexpr double energy_rounding = 1e-12;

// Newton's law may add energy where contacts with different restitutions are struck together; inelastic impulses never
// do. Of the impulses between both, returns those nearest to the law that do not. speeds: before the impact.
VectorXd without_gain(const Eigen::MatrixXd& W, const VectorXd& speeds, const VectorXd& inelastic,
                      const VectorXd& elastic) {
  const VectorXd d = elastic - inelastic;
  // Kinetic energy gained by inelastic + s d, a parabola in s that is not positive at 0.
  const double a = d.dot(W * d) / 2;
  const double b = d.dot(speeds + W * inelastic);
  const double c = std::min(0.0, inelastic.dot(speeds + W * inelastic / 2));
  if (!(a + b + c > energy_rounding * (a + std::abs(b) - c))) return elastic;
  return inelastic + (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a) * d;
}

}  // namespace

Impact solve_impact(const Eigen::MatrixXd& W, const std::vector<StruckContact>& contacts) {
  const auto n = static_cast<Index>(contacts.size());
  VectorXd speeds(n);
  VectorXd lower(n);
  VectorXd upper(n);
  for (Index i = 0; i < n; ++i) {
    const StruckContact& contact = contacts[static_cast<std::size_t>(i)];
    speeds[i] = contact.speed;
    lower[i] = contact.side > 0 || contact.held ? -unlimited : 0;
    upper[i] = contact.side < 0 || contact.held ? unlimited : 0;
  }
  const BoxSolution inelastic = solve_in_box(W, -speeds, lower, upper);
  VectorXd least = VectorXd::Zero(n);  // impulses of Poisson's law, which others may exceed
  VectorXd b = -speeds;
  for (Index i = 0; i < n; ++i) {
    const StruckContact& contact = contacts[static_cast<std::size_t>(i)];
    if (contact.poisson) {
      least[i] = (1 + contact.restitution) * inelastic.x[i];
    } else {
      b[i] -= contact.side * contact.restitution * std::max(0.0, contact.side * contact.speed);
    }
  }
  const BoxSolution elastic = solve_in_box(W, b - W * least, lower, upper);
  if (!elastic.found) return {inelastic.x, false, inelastic.found};
  return {without_gain(W, speeds, inelastic.x, least + elastic.x), true, inelastic.found};
}

}  // namespace gelenk
