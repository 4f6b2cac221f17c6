// SPDX-License-Identifier: BSD-3-Clause
#include "kinematics/placed_formulas.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinematics/loads.h"

namespace gelenk {

void each_placed_formula(const Loads& loads, const std::function<void(const Formula&, const BranchPlace&)>& visit) {
  const auto of_joint = [&](const auto& force) {
    using Of = BranchPlace::Of;
    const bool is_friction = Switches<std::decay_t<decltype(force.element)>>;
    const Of of = force.owner >= 0 ? Of::component : is_friction ? Of::friction : Of::joint;
    visit(force.element.formula(), BranchPlace{of, force.owner >= 0 ? force.owner : force.joint});
  };
  loads.tree.each_formula(of_joint);
  for (const JointLoads& on : loads.cuts) on.each_formula(of_joint);
  each_formula(std::as_const(*loads.forces), [&](const Formula& formula, int force) {
    visit(formula, BranchPlace{force < 0 ? BranchPlace::Of::gravity : BranchPlace::Of::force, force});
  });
  for (int k = 0; k < loads.states(); ++k)
    visit(loads.rates[static_cast<std::size_t>(k)], BranchPlace{BranchPlace::Of::state, k});
  for (const PlacedReset& reset : loads.resets) visit(reset.when, BranchPlace{BranchPlace::Of::reset, reset.state});
  for (int k = 0; k < static_cast<int>(loads.motions.size()); ++k) {
    if (const Formula& acceleration = loads.motions[static_cast<std::size_t>(k)][2]; acceleration.is_given())
      visit(acceleration, BranchPlace{BranchPlace::Of::motion, k});
  }
  for (int k = 0; k < static_cast<int>(loads.losses.size()); ++k)
    MeshLosses::each(loads.losses[static_cast<std::size_t>(k)],
                     [&](const Formula& formula) { visit(formula, BranchPlace{BranchPlace::Of::mesh, k}); });
}

bool holds_branches(const Formula& formula, const BranchPlace& place) {
  return !(place.of == BranchPlace::Of::mesh && MeshLosses::names_load(formula));
}

std::vector<BranchPlace> branch_places(const Loads& loads) {
  std::vector<BranchPlace> out;
  each_placed_formula(loads, [&](const Formula& formula, BranchPlace place) {
    if (!holds_branches(formula, place)) return;
    const auto first = static_cast<std::size_t>(formula.first_branch());
    const auto count = static_cast<std::size_t>(formula.branches());
    out.resize(std::max(out.size(), first + count));
    for (std::size_t k = 0; k < count; ++k) {
      place.is_knot = formula.tape().is_knot(static_cast<int>(k));
      out[first + k] = place;
    }
  });
  return out;
}

double next_break(const Loads& loads, double t) {
  double out = INFINITY;
  each_placed_formula(loads, [&](const Formula& formula, const BranchPlace&) {
    if (!formula.tape().has_breaks()) return;
    const double second = formula.clock().second;
    out = std::min(out, formula.tape().next_break(t * second) / second);
  });
  return out;
}

bool reads_time(const Loads& loads) {
  bool out = false;
  each_placed_formula(loads, [&](const Formula& formula, const BranchPlace&) { out = out || formula.reads_time(); });
  return out;
}

bool has_breaks(const Loads& loads) {
  bool out = false;
  each_placed_formula(loads,
                      [&](const Formula& formula, const BranchPlace&) { out = out || formula.tape().has_breaks(); });
  return out;
}

}  // namespace gelenk
