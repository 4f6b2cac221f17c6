// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "formulation/formulation.h"

namespace gelenk {
namespace {

constexpr std::array<FormulationKind, 8> kinds = {{
    {"projection",
     "index 1; q and v projected onto the constraints after every step, smallest change in the mass metric",
     make_projection},
    {"baumgarte", "index 1 with feedback of the constraint errors; errors remain bounded, not zero", make_baumgarte},
    {"udwadia-kalaba", "accelerations from the pseudo-inverse without stabilization; constraint errors drift",
     make_udwadia_kalaba},
    {"penalty", "constraints as mass, damper and stiff spring; errors are proportional to constraint forces",
     make_penalty},
    {"augmented-lagrangian", "penalty method with multipliers iterated to convergence in every evaluation",
     make_augmented_lagrangian},
    {"independent", "coordinate partitioning by pivoting; dependent coordinates solved for in every evaluation",
     make_independent},
    {"index3", "DAE of index 3: constraints on q, with multipliers as unknowns", make_index3},
    {"stabilized-index2",
     "DAE of index 2: constraints on q and v, with multipliers as unknowns (Gear, Gupta & Leimkuhler)",
     make_stabilized_index2},
}};

}  // namespace

std::span<const FormulationKind> formulation_kinds() { return kinds; }

std::unique_ptr<Formulation> make_formulation(std::string_view name, const FormulationContext& context) {
  const auto found = std::ranges::find(kinds, name, &FormulationKind::name);
  if (found == kinds.end()) throw std::out_of_range("no formulation is called " + std::string(name));
  return found->make(context);
}

}  // namespace gelenk
