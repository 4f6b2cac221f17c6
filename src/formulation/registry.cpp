// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "formulation/formulation.h"

namespace gelenk {
namespace {

constexpr std::array<FormulationKind, 8> kinds = {{
    {"projection", "q and v put back on the constraints after every step, least change in the mass metric",
     make_projection},
    {"baumgarte", "constraint errors fed back into the accelerations; errors stay bounded, not zero", make_baumgarte},
    {"udwadia-kalaba", "accelerations by the pseudo-inverse and no stabilisation; drifts", make_udwadia_kalaba},
    {"penalty", "constraints as stiff mass, damper and spring; errors by the penalty's size", make_penalty},
    {"augmented-lagrangian", "penalty with multipliers iterated to convergence in every evaluation",
     make_augmented_lagrangian},
    {"independent", "independent coordinates by pivoting; the others solved from them in every evaluation",
     make_independent},
    {"index3", "multipliers as unknowns beside the constraints on q; a DAE of index 3", make_index3},
    {"stabilized-index2", "multipliers as unknowns beside the constraints on q and v; a DAE of index 2",
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
