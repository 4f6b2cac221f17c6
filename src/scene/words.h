// SPDX-License-Identifier: BSD-3-Clause
// Words that a scene file may choose from.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace gelenk {

// A whole number's range.
struct IntRange {
  int least, most;
};

}  // namespace gelenk

namespace gelenk::words {

inline constexpr IntRange max_evaluations{1, std::numeric_limits<int>::max()};
inline constexpr IntRange max_events{1, std::numeric_limits<int>::max()};
inline constexpr IntRange corrections{0, 100};

// Of assembly.tolerance. What is farther off is another mechanism, not the same one with fewer digits.
inline constexpr double loosest_assembly = 1e-2;

inline const std::vector<std::string> formulations = {
    "projection",           "baumgarte",   "udwadia-kalaba", "penalty",
    "augmented-lagrangian", "independent", "index3",         "stabilized-index2"};
inline const std::vector<std::string> integrators = {
    "auto", "ida", "erk", "rk4", "euler", "cvode", "cvode-adams", "dirk", "generalized-alpha", "hht", "newmark"};
// What a run begins with: the start values, or the rest that is found from them.
inline const std::vector<std::string> starts = {"as_given", "equilibrium"};
// The integrators that a formulation goes with: all, unless it stands here.
struct Partners {
  std::string formulation;
  std::vector<std::string> integrators;
};
inline const std::vector<Partners> partners = {{"index3", {"auto", "ida", "generalized-alpha", "hht", "newmark"}},
                                               {"stabilized-index2", {"auto", "ida"}}};
// In the order of enum Reduction.
inline const std::vector<std::string> reductions = {"weld",           "static",  "cut_choice", "planar",
                                                    "redundant_rows", "islands", "outputs",    "massless"};

}  // namespace gelenk::words
