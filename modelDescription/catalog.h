// SPDX-License-Identifier: BSD-3-Clause
// Catalog: the one table of an FMU's variables. modelDescription.xml, the documentation page and the FMI
// functions all work from it, so nothing about a variable is said twice.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "joint/kind.h"
#include "scene/scene.h"
#include "simulation/parameters.h"
#include "simulation/states.h"

namespace gelenk {

enum class Causality { input, output, parameter, local };
enum class Variability { continuous, discrete, fixed, tunable };

// Where a variable's value lives.
enum class Source {
  input,       // Simulation::input
  output,      // Simulation::output
  parameter,   // Catalog::parameters()
  rate,        // Catalog::rates()
  diagnostic,  // Simulation::diagnostic
};

struct Variable {
  std::string name;
  std::string description;
  std::string unit;          // empty: none
  std::string display_unit;  // empty: the unit itself
  std::string type_name;     // "Gelenk.Angle"; empty: none
  Causality causality = Causality::local;
  Variability variability = Variability::continuous;
  ParameterType type = ParameterType::real;
  Source source = Source::diagnostic;
  int index = 0;                // in the source's list
  std::optional<double> start;  // inputs and parameters; all others are calculated
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  double nominal = 0;      // the size to expect; 0: not known
  bool hidden = false;     // an output that is not wanted, and no state or derivative of one: not in the description
  int derivative_of = -1;  // index of the variable whose time derivative this is, where it is a state
};

// The time derivative of a coordinate that no speed is: der(Q[i]) of a quaternion.
struct Rate {
  int joint = 0;      // in scene.joints
  int component = 0;  // of the joint's coordinates
};

// A continuous state and its time derivative, as indices of variables.
struct State {
  int variable = 0;
  int derivative = 0;
};

class Catalog {
 public:
  // Of a scene that was read and checked: its names are all different.
  explicit Catalog(const Scene& scene);

  // In this order: inputs, outputs, parameters, rates, diagnostics; those that are hidden, too. A variable's value
  // reference is its index.
  const std::vector<Variable>& variables() const { return variables_; }
  const Variable* find(unsigned value_reference) const {
    return value_reference < variables_.size() ? &variables_[value_reference] : nullptr;
  }

  const std::vector<Parameter>& parameters() const { return parameters_; }
  const std::vector<Rate>& rates() const { return rates_; }

  // The outputs that hold the coordinates of a joint: the first one's index in the outputs; speeds follow.
  int first_output(int joint) const { return first_output_[static_cast<std::size_t>(joint)]; }

  // Declares these as states (Simulation::independent): of a coordinate its rate is the derivative, of a speed the
  // acceleration. Of those that are not wanted, all are in the description, too, though not as outputs: a linear model
  // takes them all.
  void declare_states(const IndependentOutputs& independent);
  const std::vector<State>& states() const { return states_; }

 private:
  void add_inputs(const Scene& scene);
  void add_outputs(const Scene& scene);
  void add_parameters(const Scene& scene);
  void add_diagnostics();
  void add_sizes(const Scene& scene);
  void declare(int state, int derivative);
  void hide_unwanted(const Scene& scene);
  int output_variable(int output) const { return outputs_begin_ + output; }

  std::vector<Variable> variables_;
  std::vector<Parameter> parameters_;
  std::vector<Rate> rates_;
  std::vector<State> states_;
  std::vector<int> first_output_;        // per joint
  std::vector<const JointKind*> kinds_;  // per joint
  std::vector<int> joint_of_;            // per output; -1: a sensor's
  int outputs_begin_ = 0;
  int rates_begin_ = 0;
};

}  // namespace gelenk
