// SPDX-License-Identifier: BSD-3-Clause
// Plant: one instance of a model, seen through its catalogue: values by variable, whether they are settings of the
// scene, inputs, or computed.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fmu/runtime/settings.h"
#include "formulation/inputs.h"
#include "joint/registry.h"
#include "modelDescription/catalog.h"
#include "simulation/simulation.h"

namespace gelenk {

// What all instances of an FMU share. Immutable.
struct PlantModel {
  PlantModel(std::string_view scene_json, const std::string& file);  // throws SceneError

  Scene scene;
  Catalog catalog;
  std::string guid;

  // What modelDescription.xml declares as states: those of the scene as it was exported, whatever parameters are set.
  // Found when first asked for, by assembling it.
  struct States {
    Catalog catalog;  // with them
    IndependentOutputs independent;
  };
  const States& states() const;

 private:
  mutable std::once_flag asked_;
  mutable std::optional<States> states_;
};

class Plant {
 public:
  explicit Plant(std::shared_ptr<const PlantModel> model);

  const PlantModel& model() const { return *model_; }
  const Catalog& catalog() const { return model_->catalog; }

  // When the run starts [s], and the master's wish for the tolerance (0: none). It gives way to a solver.tolerance that
  // is set to another value than the scene's; of the scene's own, when that is set, the smaller counts: some masters
  // set all parameters to what they are, and wish for 0.1 (Maestro 3).
  void set_experiment(double start, double tolerance);

  // Builds and assembles the simulation if that has not happened since the last parameter was set.
  // Throws SceneError (settings that do not fit together), AssemblyError.
  void assemble();

  // By index in the catalogue. Values that need the simulation assemble it. Booleans are 0 and 1.
  double get(int variable);

  // Throws std::invalid_argument for what check() refuses.
  void set(int variable, double value);

  // As set(), while running: a tunable parameter then acts from the next step on, and nothing is assembled anew.
  void tune(int variable, double value);

  // The time derivative of an input, of this order and from now on (simulation.h). Throws what the check below does.
  void set_input_derivative(int variable, int order, double value);

  // Whether set() will take the value: throws std::invalid_argument, naming the variable, if not.
  void check(int variable, double value) const;
  // Likewise whether set_input_derivative() will.
  void check_input_derivative(int variable, int order, double value) const;

  // Everything that decides how the run goes on, settings included, written down or taken from a record of any instance
  // of this model; where it was assembled with other settings it is assembled anew. See Simulation::serialize. Throws
  // std::invalid_argument for a record of something else, and SceneError, AssemblyError; it is undefined then.
  void serialize(Archive& archive);

  // What is behind the outputs, assembled.
  Simulation& simulation();

  // As Simulation's; assembled plants only.
  void step_to(double end) { simulation_->step_to(end); }
  double time() const { return simulation_ ? simulation_->time() : start_; }
  long count(Diagnostic diagnostic);  // of one that counts
  std::vector<EventReport> events() const { return simulation_->events(); }
  std::string assembly_report() const;
  std::vector<std::string> start_warnings() const;

 private:
  double input(int index) const { return simulation_ ? simulation_->input(index) : inputs_.value(index); }
  double rate(const Rate& rate);
  double wished_tolerance() const;  // 0: the scene's
  void take(const Settings& assembled, const Settings& present);

  std::shared_ptr<const PlantModel> model_;
  Scene scene_;          // with the parameters set so far
  Settings settings_;    // of scene_
  Settings assembled_;   // of simulation_, when it was assembled
  Inputs inputs_;        // as set so far
  Inputs first_inputs_;  // when the simulation was assembled
  std::optional<Simulation> simulation_;
  std::vector<AnyJoint> joints_;  // as many as rates need, by joint
  double start_ = 0;
  double tolerance_ = 0;
  bool tolerance_confirmed_ = false;  // solver.tolerance was set
};

}  // namespace gelenk
