// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "complementarity/cone.h"

namespace gelenk {
namespace {

constexpr std::array<ConeSolverKind, 6> kinds = {{
    {"hybrid", "semismooth Newton, led by the spectral projected gradient; of many contacts the gradient alone",
     make_hybrid_cone_solver},
    {"p-spg-fb", "preconditioned spectral projected gradient with fall-back", make_spectral_cone_solver},
    {"apgd", "accelerated projected gradient with adaptive restarts", make_accelerated_cone_solver},
    {"newton", "semismooth Newton on the natural map", make_newton_cone_solver},
    {"admm", "alternating direction method of multipliers with an adaptive penalty", make_admm_cone_solver},
    {"gauss-seidel", "projected block Gauss-Seidel, each contact solved exactly", make_gauss_seidel_cone_solver},
}};

}  // namespace

std::span<const ConeSolverKind> cone_solver_kinds() { return kinds; }

std::unique_ptr<ConeSolver> make_cone_solver(std::string_view name) {
  const auto found = std::ranges::find(kinds, name, &ConeSolverKind::name);
  if (found == kinds.end()) throw std::out_of_range("no cone solver is called " + std::string(name));
  return found->make();
}

}  // namespace gelenk
