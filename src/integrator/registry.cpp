// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>

#include "integrator/integrator.h"
#include "integrator/starter.h"
#include "util/text.h"

namespace gelenk {
namespace {

template <auto make>
std::unique_ptr<Integrator> with_starter_of(Equations& system, const IntegratorOptions& options) {
  return with_starter(make(system, options), system, options);
}

constexpr std::array<IntegratorKind, 12> kinds = {{
    {"auto", "automatic: erk, or cvode where that costs less; ida with multipliers; moreau-jean in heaps",
     make_automatic},
    {"erk", "explicit Runge-Kutta, adaptive step and order (ARKODE), projected after each step", make_erk},
    {"ida", "BDF, variable step and order (IDA), projected within each step; for stiff scenes",
     with_starter_of<make_ida>},
    {"rk4", "classical Runge-Kutta method of order 4, fixed steps, projected after each step", make_rk4},
    {"euler", "improved Euler method of order 1, fixed steps, projected after each step", make_euler},
    {"cvode", "BDF, variable step and order (CVODES), projected within each step; for stiff scenes",
     with_starter_of<make_cvode>},
    {"cvode-adams", "Adams-Moulton, variable step and order (CVODES), projected after each step",
     with_starter_of<make_cvode_adams>},
    {"dirk", "diagonally implicit Runge-Kutta, L-stable, adaptive steps (ARKODE), projected after each step",
     make_dirk},
    {"generalized-alpha", "implicit, second order with damping of high frequencies, fixed steps (Chung & Hulbert)",
     make_generalized_alpha},
    {"hht", "implicit, second order with damping of high frequencies, fixed steps (Hilber, Hughes & Taylor)", make_hht},
    {"newmark", "trapezoidal rule: implicit, second order without numerical damping, fixed steps", make_newmark},
    {"moreau-jean", "time stepping with contacts, friction and limits by impulses, fixed steps (Moreau; Jean)",
     make_moreau_jean},
}};

}  // namespace

std::span<const IntegratorKind> integrator_kinds() { return kinds; }

std::unique_ptr<Integrator> make_integrator(std::string_view name, Equations& system,
                                            const IntegratorOptions& options) {
  const auto found = std::ranges::find(kinds, name, &IntegratorKind::name);
  if (found == kinds.end()) throw std::out_of_range("no integrator is called " + std::string(name));
  return found->make(system, options);
}

std::string StallDetector::step_to(double t) {
  if (++count_ < window) return {};
  if (t - mark_ < min_advance_) {
    return "the last " + std::to_string(window) + " steps advanced the time by only " + text::rounded(t - mark_) + " s";
  }
  count_ = 0;
  mark_ = t;
  return {};
}

std::string at_time(double t) { return "t = " + text::rounded(t) + " s: "; }

void refuse(Equations& system, double t, const double* y, const std::string& why) {
  const std::string obstacle = system.obstacle(y);
  throw IntegrationError(at_time(t) + (obstacle.empty() ? why : obstacle));
}

}  // namespace gelenk
