// SPDX-License-Identifier: BSD-3-Clause
// The settings of the solver in the form in which an island's formulation and integrator take them.
#pragma once

#include "formulation/formulation.h"
#include "scene/scene.h"
#include "scene/shapes.h"

namespace gelenk {

// Step of fixed-step methods [s].
inline double step_of(const Scene& scene) { return scene.solver.step > 0 ? scene.solver.step : scene.experiment.step; }

inline FormulationOptions options_of(const Scene& scene, const double* best_pivot_ratio) {
  const Solver& solver = scene.solver;
  return {step_of(scene),     solver.baumgarte_alpha,  solver.baumgarte_beta,
          solver.corrections, locates_contacts(scene), best_pivot_ratio};
}

// Whether the equations of motion may be evaluated by a program.
inline bool traces_equations(const Solver& solver) {
  return solver.formulation == "projection" && solver.equations != "general";
}

}  // namespace gelenk
