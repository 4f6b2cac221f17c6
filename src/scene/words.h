// SPDX-License-Identifier: BSD-3-Clause
// Permitted words and ranges of the settings of a scene file.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace gelenk {

// Range of an integer, ends included.
struct IntRange {
  int min, max;
};

}  // namespace gelenk

namespace gelenk::words {

inline constexpr IntRange max_evaluations{1, std::numeric_limits<int>::max()};
inline constexpr IntRange max_events{1, std::numeric_limits<int>::max()};
// Bounds of experiment.tolerance: below, the error estimate of a step is only round-off; above, it is meaningless.
inline constexpr double min_tolerance = 1e-15;
inline constexpr double max_tolerance = 1;
// Bounds of solver.cone_tolerance: below, residuals are only round-off.
inline constexpr double min_cone_tolerance = 1e-14;
inline constexpr double max_cone_tolerance = 0.1;

inline constexpr IntRange corrections{0, 100};

// Upper bound of assembly.tolerance: dimensions with a larger error describe another mechanism, not a rounded one.
inline constexpr double max_assembly_tolerance = 1e-2;

inline const std::vector<std::string> formulations = {
    "projection",           "baumgarte",   "udwadia-kalaba", "penalty",
    "augmented-lagrangian", "independent", "index3",         "stabilized-index2"};
inline const std::vector<std::string> integrators = {
    "auto", "ida",     "erk",        "rk4", "euler", "cvode", "cvode-adams", "dirk", "generalized-alpha",
    "hht",  "newmark", "moreau-jean"};
// Initial state of a run: the start values, or the equilibrium found from them.
inline const std::vector<std::string> starts = {"as_given", "equilibrium"};
// How the equations of motion are evaluated: by the kernels, or traced, by a program that is made for the scene, where
// that is possible; automatic: at present as traced.
inline const std::vector<std::string> equations = {"automatic", "general", "traced"};
// Integrators that a formulation can be combined with; formulations not listed here permit all.
struct FormulationIntegrators {
  std::string formulation;
  std::vector<std::string> integrators;
};
inline const std::vector<FormulationIntegrators> allowed_integrators = {
    {"index3", {"auto", "ida", "generalized-alpha", "hht", "newmark"}}, {"stabilized-index2", {"auto", "ida"}}};
// In the order of enum Reduction.
inline const std::vector<std::string> reductions = {"weld",    "static",  "cut_choice", "planar",   "redundant_rows",
                                                    "islands", "outputs", "massless",   "kinematic"};

}  // namespace gelenk::words
