// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>

#include "integrator/integrator.h"

namespace gelenk {
namespace {

constexpr std::array<IntegratorKind, 3> kinds = {{
    {"erk", "explicit Runge-Kutta, adaptive steps, order by tolerance (ARKODE), projected after each step", make_erk},
    {"ida", "BDF of variable order (IDA), projected within each step; for stiff scenes", make_ida},
    {"rk4", "the classical Runge-Kutta method of order 4 with fixed steps, projected after each step", make_rk4},
}};

}  // namespace

std::span<const IntegratorKind> integrator_kinds() { return kinds; }

std::unique_ptr<Integrator> make_integrator(std::string_view name, OdeSystem& system,
                                            const IntegratorOptions& options) {
  const auto found = std::ranges::find(kinds, name, &IntegratorKind::name);
  if (found == kinds.end()) throw std::out_of_range("no integrator is called " + std::string(name));
  return found->make(system, options);
}

void Patience::step_to(double t) {
  if (++count_ < window) return;
  if (t - mark_ < least_) {
    char text[96];
    std::snprintf(text, sizeof text, "the last %d steps took the run only %.3g s further", window, t - mark_);
    throw IntegrationError(at_time(t) + text);
  }
  count_ = 0;
  mark_ = t;
}

std::string at_time(double t) {
  char text[64];
  std::snprintf(text, sizeof text, "t = %.9g s: ", t);
  return text;
}

}  // namespace gelenk
