// SPDX-License-Identifier: BSD-3-Clause
#include "modes/impact.h"

#include <algorithm>
#include <cmath>

#include "linear/box_complementarity.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of the terms of the energy of an impact.
constexpr double energy_rounding = 1e-12;
// Of the part of the restitution that adds no energy.
constexpr int most_bisections = 50;

// Whether impulses add energy, at these speeds before them.
bool gain(const Eigen::MatrixXd& W, const VectorXd& speeds, const VectorXd& impulses) {
  const double before = impulses.dot(speeds);
  const double change = impulses.dot(W * impulses) / 2;
  return before + change > energy_rounding * (std::abs(before) + change);
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
  const auto with_restitution = [&](double part) {
    VectorXd least = VectorXd::Zero(n);  // impulses of Poisson's law, which others may exceed
    VectorXd b = -speeds;
    for (Index i = 0; i < n; ++i) {
      const StruckContact& contact = contacts[static_cast<std::size_t>(i)];
      const double restitution = part * contact.restitution;
      if (contact.poisson) {
        least[i] = (1 + restitution) * inelastic.x[i];
      } else {
        b[i] -= contact.side * restitution * std::max(0.0, contact.side * contact.speed);
      }
    }
    BoxSolution out = solve_in_box(W, b - W * least, lower, upper);
    out.x += least;
    return out;
  };
  BoxSolution elastic = with_restitution(1);
  if (!elastic.found) return {inelastic.x, false, inelastic.found};
  if (!gain(W, speeds, elastic.x)) return {elastic.x, true, inelastic.found};
  // Newton's law may add energy where contacts with different restitutions are struck together; inelastic impulses
  // never do. Restitution is reduced to what does not, as in ContactImpact.
  double low = 0, high = 1;
  VectorXd impulses = inelastic.x;
  for (int k = 0; k < most_bisections; ++k) {
    const double middle = (low + high) / 2;
    elastic = with_restitution(middle);
    const bool gains = !elastic.found || gain(W, speeds, elastic.x);
    if (!gains) impulses = elastic.x;
    (gains ? high : low) = middle;
  }
  return {impulses, true, inelastic.found};
}

}  // namespace gelenk
