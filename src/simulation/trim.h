// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "analysis/equilibrium.h"

namespace gelenk {

// How a search for an equilibrium or a steady motion of a simulation has ended.
struct Trim {
  Equilibrium::End end = Equilibrium::End::found;  // of the island where the least was found
  int steps = 0;
  bool is_driven = false;                          // a prescribed motion may act
  std::vector<std::pair<int, double>> residual{};  // accelerations that remain [SI]: outputs and values
};

}  // namespace gelenk
