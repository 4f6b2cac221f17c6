// SPDX-License-Identifier: BSD-3-Clause
// Plant: one instance of a model, with access by the variables of its catalog: parameters of the scene, inputs and
// computed values.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fmu/runtime/settings.h"
#include "formulation/inputs.h"
#include "modelDescription/catalog.h"
#include "simulation/model_exchange.h"
#include "simulation/simulation.h"

namespace gelenk {

// Immutable data shared by all instances of an FMU.
struct PlantModel {
  PlantModel(std::string_view scene_json, const std::string& file);  // throws SceneError

  Scene scene;
  Catalog catalog;
  std::string guid;

  // The states that modelDescription.xml declares: those of the exported scene, independent of parameters set later.
  // Determined on first use, by assembling the scene.
  struct States {
    Catalog catalog;  // with these states declared
    IndependentOutputs independent;
    // By variable: index of the state that it is, or of which it is the derivative; -1: none.
    std::vector<int> index_of, index_of_derivative;
  };
  const States& states() const;
  // How many variables for event indicators follow those of the catalog in FMI 3.0: none if the FMU is for
  // co-simulation only. Determined on first use, as the states are.
  int indicators() const;

 private:
  mutable std::once_flag states_once_, indicators_once_;
  mutable std::optional<States> states_;
  mutable int indicators_ = 0;
};

// Movable before it is assembled.
class Plant {
 public:
  // What advances its states: its own integrator (co-simulation), or that of the importer (model exchange).
  enum class Kind { co_simulation, model_exchange };
  explicit Plant(std::shared_ptr<const PlantModel> model, Kind kind = Kind::co_simulation);

  Kind kind() const { return kind_; }

  const PlantModel& model() const { return *model_; }
  const Catalog& catalog() const { return model_->catalog; }

  // Sets the start time [s] and the tolerance requested by the master (0: none). A value of solver.tolerance that
  // differs from the scene's takes precedence over it. If solver.tolerance is set to the scene's value, the smaller of
  // the two applies: some masters set all parameters to their defaults and request 0.1 (Maestro 3).
  void set_experiment(double start, double tolerance);

  // Creates and assembles the simulation unless this has been done since a parameter was last set. Throws SceneError
  // for inconsistent parameters, and AssemblyError.
  void assemble();

  // The value of a variable, by its index in the catalog; assembles the simulation if necessary. Booleans are 0 and 1.
  double get(int variable);

  // Throws std::invalid_argument for what check() rejects.
  void set(int variable, double value);

  // As set(), during a run: a tunable parameter takes effect from the next step on, without a new assembly.
  void tune(int variable, double value);

  // Sets the time derivative of this order of an input (simulation.h). Throws what check_input_derivative() throws.
  void set_input_derivative(int variable, int order, double value);

  // Throws std::invalid_argument, with the variable's name, if set() would reject the value.
  void check(int variable, double value) const;
  // The same for set_input_derivative().
  void check_input_derivative(int variable, int order, double value) const;

  // Writes or reads all data that determine how the run continues, including parameters; archives of any instance of
  // this model can be read. If that was assembled with other parameters, this plant is assembled again. See
  // Simulation::serialize. Throws std::invalid_argument for an archive of something else, SceneError and AssemblyError;
  // the plant must then not be used.
  void serialize(Archive& archive);

  // The assembled simulation, at the present states; assembles it if necessary.
  Simulation& simulation();
  // With model exchange; assembles it if necessary. Its states are those of PlantModel::states(), in that order.
  ModelExchange& exchange();
  // The values of PlantModel::indicators(); 0 with co-simulation, which passes events within its steps.
  std::vector<double> indicator_values();
  // The expected magnitude of a state.
  double nominal(std::size_t state) const;

  // See Simulation; require an assembled plant.
  void step_to(double end) { simulation_->step_to(end); }
  double time() const { return exchange_ ? exchange_->time() : simulation_ ? simulation_->time() : start_; }
  std::vector<EventReport> events(bool only_doubtful) const { return simulation_->events(only_doubtful); }
  std::string assembly_report() const;
  std::vector<std::string> start_warnings() const;

 private:
  double input(int index) const { return simulation_ ? simulation_->input(index) : inputs_.value(index); }
  double rate(int variable, const Rate& rate);
  void make_exchange();
  bool is_settable_state(int variable) const;
  double present_state(int variable) const;
  void discard_simulation();
  double requested_tolerance() const;  // 0: the scene's
  void adopt(const Settings& assembled, const Settings& present);

  std::shared_ptr<const PlantModel> model_;
  Scene scene_;          // with the parameters set so far
  Settings settings_;    // of scene_
  Settings assembled_;   // when simulation_ was assembled
  Inputs inputs_;        // as set so far
  Inputs first_inputs_;  // when simulation_ was assembled
  std::optional<Simulation> simulation_;
  std::unique_ptr<ModelExchange> exchange_;  // of simulation_
  Kind kind_;
  double start_ = 0;
  double tolerance_ = 0;
  bool tolerance_confirmed_ = false;  // whether solver.tolerance was set
};

}  // namespace gelenk
