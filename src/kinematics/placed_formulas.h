// SPDX-License-Identifier: BSD-3-Clause
// The expressions that act on an island, with the places where they act.
#pragma once

#include <functional>
#include <vector>

namespace gelenk {

class Formula;
struct Loads;

// By branch of all expressions: the joint, the component or the force of the scene, the element state or the coordinate
// row among those of the island.
struct BranchPlace {
  enum class Of { joint, friction, component, force, gravity, state, reset, mesh, motion } of = Of::joint;
  int index = 0;
  bool is_knot = false;  // of a table, where nothing jumps
};
std::vector<BranchPlace> branch_places(const Loads& loads);
// Whether the branches of an expression there are held in steps: not those that forces decide on.
bool holds_branches(const Formula& formula, const BranchPlace& place);

void each_placed_formula(const Loads& loads, const std::function<void(const Formula&, const BranchPlace&)>& visit);

// Whether an expression that acts reads the time.
bool reads_time(const Loads& loads);
// Knots of tables of the time, see EventSource.
double next_break(const Loads& loads, double t);
bool has_breaks(const Loads& loads);

}  // namespace gelenk
