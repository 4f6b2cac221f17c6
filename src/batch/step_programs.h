// SPDX-License-Identifier: BSD-3-Clause
// The programs of which a step is made, and the slots that they share.
#pragma once

#include <vector>

#include "equations/scene_equations.h"
#include "lanes/program.h"
#include "recorded/elimination.h"

namespace gelenk {

// The first of consecutive slots.
struct StepSlots {
  int y = 0;       // where the equations are evaluated: q, v, element states
  int rates = 0;   // of these; not of coordinates of which the rates are velocities
  int before = 0;  // the state at the start of the step
  int sum = 0;     // of the rates of the stages
  int u = 0;       // inputs
  int time = 0;    // one
  int Phi = 0;     // by row of the pivots; what a displacement removes is here, too
  int rate = 0;    // J v - b
  int displacement = 0;
  int moved = 0;      // rates of the coordinates at this displacement, if they are not velocities
  int numbers = 0;    // that vary
  int constants = 0;  // what depends on these alone
  int factors = 0;    // what displacement needs from the last evaluation
};

struct StepTerms;

struct StepPrograms {
  // varied: as many variables from VariedNumbers::first_variable on.
  StepPrograms(const SceneEquations& equations, const Pivots& pivots, int varied);

  lanes::Frame frame;
  StepSlots slots;
  int nq = 0, nv = 0, states = 0, inputs = 0, rows = 0, varied = 0;
  int constants = 0, factors = 0;  // how many
  bool reads_time = false;
  bool rates_are_velocities = true;  // of the coordinates
  std::vector<int> quaternions;      // their first coordinates
  std::vector<int> rate_slots;       // where the rate of each row of y is

  lanes::Program prepare;          // constants, once
  lanes::Program evaluate;         // rates and factors
  lanes::Program evaluate_closed;  // the same where `gaps` has run at this state
  lanes::Program gaps;             // Phi, what `gap_rates` needs of positions, and sines and cosines
  lanes::Program gap_rates;        // rate
  lanes::Program displace;         // displacement, from Phi and the factors
  lanes::Program move;             // moved

  // The reciprocal of a pivot that varies, among the factors.
  struct Guard {
    int slot = 0;
    bool is_mass = false;
    int of = 0;  // constraint equation, or velocity of a mass
  };
  std::vector<Guard> guards;

  int size() const { return nq + nv + states; }
  // Instructions of an evaluation.
  int operations() const { return static_cast<int>(evaluate.instructions().size()); }

 private:
  void place();
  lanes::Slots variables(expression::Graph& graph) const;
  void compile_closing(expression::Graph& graph, const StepTerms& of, const lanes::Slots& known,
                       const std::vector<lanes::Output>& evaluated);
  void add_guards(const std::vector<expression::Term>& among, const std::vector<expression::Term>& reciprocals,
                  bool is_mass, const std::vector<int>& by);
};

}  // namespace gelenk
