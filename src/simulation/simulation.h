// SPDX-License-Identifier: BSD-3-Clause
// Simulation: one running instance of a scene.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "event/event_log.h"
#include "math/spatial.h"
#include "preparation/assembly_error.h"
#include "scene/scene.h"
#include "scene/signals.h"

namespace gelenk {

class Archive;
struct BodyWrench;
struct EquilibriumRequest;
struct ReducedScene;
struct RestForces;
struct Trim;

// A step failed. The simulation is at its last good time and can continue from there.
class StepError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A step ended early, at time(), because its evaluation budget (solver.max_evaluations) was exhausted. The rest can be
// simulated by another call of step_to().
class StepBudgetError : public StepError {
  using StepError::StepError;
};

// An invalid call, for example with an input that is not finite or a step back in time.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A derivative does not exist at the present state, because the configuration is singular.
class NotDifferentiable : public UsageError {
  using UsageError::UsageError;
};

// Sizes of the model behind a scene.
struct ModelSize {
  int bodies = 0;              // bodies that can move; welded bodies count as one
  int coordinates = 0;         // nq
  int speeds = 0;              // generalized velocities, nv
  int rows = 0;                // constraint equations
  int rank = 0;                // of the constraint Jacobian, at a position without special symmetry
  int degrees_of_freedom = 0;  // speeds - rank
  int free_coordinates = 0;    // independent coordinates: one more than that for each nonholonomic constraint
  int element_states = 0;

  int states() const { return degrees_of_freedom + free_coordinates + element_states; }  // the smallest number
  int islands = 0;         // parts without coupling, integrated separately
  int planar_islands = 0;  // islands computed in their plane
  bool planar = false;     // whether all islands are
};

// Sizes before initialize(): rank and degrees_of_freedom are 0, since they are not known yet.
ModelSize size_of(const ReducedScene& reduced);

// A running scene: state, inputs, outputs and steps. Not thread-safe; different simulations may run in different
// threads.
class Simulation {
 public:
  // Applies the reductions to the whole scene, including parts that no wanted output depends on
  // (mechanism/wanted_part.h). Throws SceneError for errors that involve several fields, such as a moving body without
  // inertia.
  explicit Simulation(const Scene& scene);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // Closes the loops at the start values, makes positions and velocities consistent at `time` [s] and creates the
  // integrators. tolerance: relative; overrides the scene's if positive. Throws AssemblyError, and UsageError if time
  // is not finite.
  void initialize(double time = 0, double tolerance = 0);
  // The same without integrators: outputs, states and derivatives are available at the start, steps are not.
  void assemble(double time = 0);

  // Advances to `end` [s] with the present inputs and their derivatives; inputs may have jumped since the last step.
  // Throws StepError (the state at time() is unchanged), StepBudgetError (time() is between start and end of the step;
  // inputs continue to follow their derivatives), and UsageError if end < time() or is not finite.
  void step_to(double end);

  // Writes or reads all data that determine how the run continues: time, state, inputs, memory of the methods. Both
  // runs then continue with identical bits, as does any instance of the same scene that was initialized at the same
  // time and tolerance and has the same tuned parameters. Methods with a history (ida, cvode, cvode-adams, dirk) are
  // saved as their last restart and the steps since (replay.h). Requires initialize(). Throws std::invalid_argument for
  // an archive of something else; the simulation must then not be used until a valid archive has been read.
  void serialize(Archive& archive);

  double time() const;
  const Scene& scene() const;
  const ModelSize& size() const;

  // The signals in the order of signals.h, including outputs that are not wanted (wanted_outputs.h).
  const std::vector<Signal>& inputs() const;
  const std::vector<Signal>& outputs() const;
  const std::vector<Signal>& diagnostics() const;

  // Throws UsageError for a value that is not finite, naming the input; the former value is kept.
  void set_input(int index, double value);
  double input(int index) const;
  // Sets the time derivative of this order, 1 to 5, [unit/s^order] at time(). During the next step the input is the
  // Taylor polynomial of its value and derivatives, which may be set in any order. Afterwards it is held at the value
  // reached unless new derivatives are set. Throws UsageError for another order or a value that is not finite.
  // Derivatives of a prescribed motion whose value alone is set are estimated (formulation/inputs.h).
  void set_input_derivative(int index, int order, double value);
  double input_derivative(int index, int order) const;  // at time()
  // Takes the tunable numbers (Parameter::tunable) from `scene`, which is otherwise the scene this was created from;
  // the effect is that of an input that jumps. Requires initialize().
  void tune(const Scene& scene);
  // Outputs and diagnostics are computed when first read after a change of the state or the inputs.
  double output(int index);
  double diagnostic(int index);
  // X_WB of a body of the scene, by its number: the pose of its frame in the world [m].
  Pose3 body_pose(int body);

  // Searches for an equilibrium or a steady motion from the present state, with limits, each island on its own: they
  // are not coupled. If all is found, the simulation is there afterwards, with the inputs found, as after assemble();
  // otherwise it remains where it was. At rest friction has no effect, and velocities that prescribed motions cause are
  // permitted. request: outputs and inputs of the simulation, in SI units; joints are known from outputs. Throws
  // NotDifferentiable.
  Trim trim(const EquilibriumRequest& request);
  // What elements exert on bodies at the present state, in SI units.
  std::vector<BodyWrench> wrenches();

  // What friction and limits have to do to keep the present position at rest, under the present inputs.
  RestForces rest_forces();

  // The events of the last step_to() in order of time: stops engaged or disengaged, singular configurations crossed. If
  // there are very many, the first ones of each island. Also jumps of prescribed motions. only_doubtful: those that
  // leave the further motion in doubt.
  std::vector<EventReport> events(bool only_doubtful = false) const;

 private:
  friend class StateDerivatives;  // state_derivatives.h
  friend class StartReport;       // start_report.h
  friend class RepeatedStart;     // repeated_start.h
  friend class SteppingReport;    // stepping_report.h
  friend class Probe;             // probe.h
  friend class Placement;         // placement.h
  friend class ModelExchange;     // model_exchange.h

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gelenk
