// SPDX-License-Identifier: BSD-3-Clause
// Motions that follow element states: the value and the speed must be smooth, since no force makes a coordinate jump.
#include "scene/motions.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "check/check.h"
#include "expression/error.h"
#include "scene/formulas.h"
#include "util/text.h"

namespace gelenk {
namespace {

// What is found of an expression that is the value (order 0) or the speed of a motion; empty: nothing is wrong.
std::string fault_of(const Scene& scene, const Formula& formula, int order) {
  const std::string what = order == 0 ? " in its value" : " in its speed";
  for (const std::string& name : formula.signal_names()) {
    if (std::ranges::find(scene.inputs, name, &SceneInput::name) != scene.inputs.end())
      return "the input " + text::quoted(name) + what + ", which would jump with it";
  }
  if (formula.branches() > 0) return "a kink" + what + ", where the speed or the acceleration would have to jump";
  if (order == 0 && !formula.tape().is_steady())
    return "a table" + what + " whose derivative jumps (linear, or with the extrapolation hold)";
  return {};
}

// The same of what it follows.
std::string fault_of_names(const Scene& scene, const Formula& formula) {
  for (const std::string& name : formula.signal_names()) {
    const auto state = std::ranges::find(scene.states, name, &ElementState::name);
    const bool is_input = std::ranges::find(scene.inputs, name, &SceneInput::name) != scene.inputs.end();
    if (state == scene.states.end() && !is_input && name != time_signal)
      return text::quoted(name) + ", which moves with the mechanism";
    if (state == scene.states.end()) continue;
    if (!state->resets.empty()) return "the state " + text::quoted(name) + ", which jumps at its resets";
    if (state->rate.reads_forces()) return "the state " + text::quoted(name) + ", whose rate names forces";
  }
  return {};
}

std::string fault_of(const Scene& scene, const Motion& motion, const FormulaNames& names) {
  std::string found;
  const auto look = [&](const Formula& formula, int order) {
    if (found.empty()) found = fault_of_names(scene, formula);
    if (found.empty() && order < 2) found = fault_of(scene, formula, order);
  };
  try {
    look(motion_of_signals(scene, motion, names, look).back(), 2);
  } catch (const expression::SyntaxError& error) {
    if (found.empty())
      found = std::string("an expression of which the time derivatives cannot be formed: ") + error.what();
  }
  return found;
}

}  // namespace

void check_motions(const Scene& scene, Faults& faults) {
  if (!has_motions_of_signals(scene)) return;
  const FormulaNames names = formula_names(scene);
  for (const Constraint& constraint : scene.constraints) {
    const Motion* const motion = find_motion_of_signals(constraint);
    if (motion == nullptr) continue;
    const std::string path = "constraints." + text::printable(constraint.name);
    const bool is_speed = motion->gives_speed_by_law();
    if (const std::string found = fault_of(scene, *motion, names); !found.empty()) {
      faults.add(path + (is_speed ? ".speed_law" : ".law"), found,
                 "a smooth expression of the time and of states whose rates depend on the time, inputs and states "
                 "alone; an input is followed through a state, such as that of a " +
                     std::string(is_speed ? "first_order" : "second_order") + " component");
      continue;
    }
    const std::string& formulation = scene.solver.formulation;
    if (formulation == "index3" || formulation == "stabilized-index2")
      faults.add("solver.formulation", text::quoted(formulation) + " with " + path + ", which follows states",
                 "another formulation, such as projection");
  }
}

}  // namespace gelenk
