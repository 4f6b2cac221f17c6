// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>

#include "integrator/integrator.h"
#include "integrator/started.h"
#include "util/text.h"

namespace gelenk {
namespace {

template <auto make>
std::unique_ptr<Integrator> started(Equations& system, const IntegratorOptions& options) {
  return with_starter(make(system, options), system, options);
}

constexpr std::array<IntegratorKind, 11> kinds = {{
    {"auto", "erk, and cvode where that is cheaper; ida for formulations with multipliers", make_automatic},
    {"erk", "explicit Runge-Kutta, adaptive steps, order by tolerance (ARKODE), projected after each step", make_erk},
    {"ida", "BDF of variable order (IDA), projected within each step; for stiff scenes", started<make_ida>},
    {"rk4", "the classical Runge-Kutta method of order 4 with fixed steps, projected after each step", make_rk4},
    {"euler", "the improved Euler method of order 1 with fixed steps, projected after each step", make_euler},
    {"cvode", "BDF of variable order (CVODES), projected by its own hook; for stiff scenes", started<make_cvode>},
    {"cvode-adams", "Adams-Moulton of variable order (CVODES), projected after each step", started<make_cvode_adams>},
    {"dirk", "implicit Runge-Kutta, L-stable, adaptive steps (ARKODE), projected after each step", make_dirk},
    {"generalized-alpha", "second order with damping of what is fast, implicit, fixed steps (Chung & Hulbert)",
     make_generalized_alpha},
    {"hht", "second order with damping of what is fast, implicit, fixed steps (Hilber, Hughes & Taylor)", make_hht},
    {"newmark", "the trapezoidal rule, second order without damping, implicit, fixed steps", make_newmark},
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
  if (t - mark_ < least_) {
    return "the last " + std::to_string(window) + " steps took the run only " + text::rounded(t - mark_) + " s further";
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
