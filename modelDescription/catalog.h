// SPDX-License-Identifier: BSD-3-Clause
// Catalog: the table of an FMU's variables, from which modelDescription.xml, the documentation page and the FMI
// functions are all derived.
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

enum class Causality { input, output, parameter, local, independent };
enum class Variability { continuous, discrete, fixed, tunable };

// The source of a variable's value.
enum class Source {
  input,       // Simulation::input
  output,      // Simulation::output
  parameter,   // Catalog::parameters()
  rate,        // Catalog::rates()
  diagnostic,  // Simulation::diagnostic
  time,        // Simulation::time
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
  int index = 0;                // in the list of the source
  std::optional<double> start;  // of inputs and parameters; all others are calculated
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  double nominal = 0;  // expected magnitude; 0: not known
  // Not in modelDescription.xml: an output that is neither wanted, a state nor its derivative; the time, which FMI 3.0
  // alone describes.
  bool hidden = false;
  int derivative_of = -1;  // index of the state variable whose time derivative this is; -1: none
};

// The time derivative of what can be a state: a variable of its own, since importers such as CasADi do not accept an
// output as the derivative of another variable.
struct Rate {
  int of = 0;         // output
  int same_as = -1;   // output with the same value; -1: none, of a quaternion
  int joint = -1;     // of a quaternion: in scene.joints
  int component = 0;  // among the joint's coordinates
};

// A continuous state and its time derivative, as indices of variables.
struct State {
  int variable = 0;
  int derivative = 0;
};

class Catalog {
 public:
  // Creates the catalog of a scene that has been checked, so that all names are different.
  explicit Catalog(const Scene& scene);

  // All variables, including hidden ones, in this order: inputs, outputs, parameters, rates, diagnostics, time. The
  // value reference of a variable is its index.
  const std::vector<Variable>& variables() const { return variables_; }
  const Variable* find(unsigned value_reference) const {
    return value_reference < variables_.size() ? &variables_[value_reference] : nullptr;
  }

  const std::vector<Parameter>& parameters() const { return parameters_; }
  const std::vector<Rate>& rates() const { return rates_; }

  int output_variable(int output) const { return outputs_begin_ + output; }
  // Index, among the outputs, of the first coordinate of a joint; the velocities follow the coordinates.
  int first_output(int joint) const { return first_output_[static_cast<std::size_t>(joint)]; }

  // Declares these outputs as states (StateDerivatives::independent), with rates as derivatives, in the order of the
  // outputs. States that are not wanted as outputs are also in the description, as local variables, since a linear
  // model requires all of them.
  void declare_states(const IndependentOutputs& independent);
  const std::vector<State>& states() const { return states_; }

 private:
  void add_inputs(const Scene& scene);
  void add_outputs(const Scene& scene);
  void add_parameters(const Scene& scene);
  void add_rates(const Scene& scene);
  void add_diagnostics();
  void add_time();
  void add_nominals(const Scene& scene);
  void hide_unwanted(const Scene& scene);

  std::vector<Variable> variables_;
  std::vector<Parameter> parameters_;
  std::vector<Rate> rates_;
  std::vector<State> states_;
  std::vector<int> first_output_;        // per joint
  std::vector<const JointKind*> kinds_;  // per joint
  int outputs_begin_ = 0;
  int rates_begin_ = 0;
};

}  // namespace gelenk
