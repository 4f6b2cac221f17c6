// SPDX-License-Identifier: BSD-3-Clause
// The integrator behind `auto`.
#pragma once

#include <string>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// The name in scene.solver.integrator; for `auto`, ida where the start looks stiff, else erk. Stiff: following the
// fastest decay at (y, u), found by power iteration on differences of vdot, would cost an explicit method thousands
// of steps over the experiment.
std::string choose_integrator(const Scene& scene, const Mechanism& mechanism, Dynamics& dynamics,
                              const std::vector<double>& y, const std::vector<double>& u);

}  // namespace gelenk
