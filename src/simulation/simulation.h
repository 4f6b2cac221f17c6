// SPDX-License-Identifier: BSD-3-Clause
// Simulation: one running instance of a scene.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "derivatives/jacobians.h"
#include "formulation/equations.h"
#include "preparation/adjustment.h"
#include "preparation/preparation.h"
#include "scene/scene.h"
#include "scene/signals.h"
#include "simulation/sensitivity.h"
#include "util/archive.h"

namespace gelenk {

// A step could not be made. The simulation stands at its last good time and can go on from there.
class StepError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A step has used up its evaluations (solver.max_evaluations) and ended early: time() tells where. What is left of it
// can be asked for in another step.
class StepBudgetError : public StepError {
  using StepError::StepError;
};

// A wrong call: an input that is not finite, a step back in time.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A derivative that does not exist at the present state: a singular position.
class NotDifferentiable : public UsageError {
  using UsageError::UsageError;
};

// Sizes of the model behind a scene.
struct ModelSize {
  int bodies = 0;              // that can move, after merging welds
  int coordinates = 0;         // nq
  int speeds = 0;              // nv
  int rows = 0;                // of the loops
  int rank = 0;                // of the rows, at a position without special symmetry
  int degrees_of_freedom = 0;  // speeds - rank
  int free_coordinates = 0;    // as many, and one more for each row that holds a speed and no position
  int islands = 0;             // parts solved apart
  int planar_islands = 0;
  bool planar = false;  // all of them
};

// rank and freedoms stay 0: they are known after initialize() only.
ModelSize size_of(const ReducedScene& reduced);

// Not thread-safe; different simulations may run in different threads.
class Simulation {
 public:
  // Compiles the scene as it is, what its wanted outputs do not need, too (mechanism/wanted_part.h). Throws SceneError
  // for what no single field shows (a body without inertia that moves).
  explicit Simulation(const Scene& scene);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // Closes the loops at the start values and makes everything consistent at `time` [s].
  // tolerance: overrides the scene's when positive. Throws AssemblyError.
  void initialize(double time = 0, double tolerance = 0);
  // Likewise without an integrator: outputs, states and derivatives at the start are to be had, steps are not.
  void assemble(double time = 0);

  // Advances to `end` [s] under the inputs set now, which follow the derivatives set with them. Inputs may differ from
  // those of the step before.
  // Throws StepError (state unchanged since time()); StepBudgetError, of which inputs then go on by their derivatives;
  // UsageError when end < time() or is not finite.
  void step_to(double end);

  // Writes down, or takes from a record, everything that decides how the run goes on: time, state, inputs, what methods
  // carry from step to step. It then goes on to the same bits in both runs, and in any instance of the same scene that
  // was initialized at the same time and tolerance and has been tuned alike. Methods with a history (ida, cvode,
  // cvode-adams, dirk) begin anew at a record, in the run that wrote it, too. After initialize(). Throws
  // std::invalid_argument for a record of something else; the simulation is undefined then, until it takes a right one.
  void serialize(Archive& archive);

  double time() const;
  const Scene& scene() const;
  const ModelSize& size() const;

  // Signals, in the order of signals.h; of outputs those that are not wanted, too (wanted_outputs.h).
  const std::vector<Signal>& inputs() const;
  const std::vector<Signal>& outputs() const;
  const std::vector<Signal>& diagnostics() const;

  // Throws UsageError for a value that is not finite, naming the input; the former value stays.
  void set_input(int index, double value);
  double input(int index) const;
  // The time derivative of this order, 1 to 5, [unit/s^order] at time(): from there to the end of the next step the
  // input is the polynomial of its value and its derivatives, in whichever order they are set. After it the input is
  // held at the value reached, unless new derivatives are set. Throws UsageError for another order, or a value that is
  // not finite.
  void set_input_derivative(int index, int order, double value);
  double input_derivative(int index, int order) const;  // as set, at time()
  // Takes what may change during a run (Parameter::tunable) from `scene`, otherwise the one this was made of; as an
  // input that jumps. After initialize().
  void tune(const Scene& scene);
  double output(int index);      // computed when first read after a change
  double diagnostic(int index);  // likewise
  // X_WB of a body of the scene, by its number: the pose of its frame in the world.
  Pose3 body_pose(int body);

  // Of the last step_to(), in order of time: stops that were met or left, singular positions that were passed. Of one
  // with very many, the first of each part that is solved by itself.
  std::vector<EventReport> events() const;

 private:
  friend class StateDerivatives;  // state_derivatives.h
  friend class StartReport;       // start_report.h
  friend class Probe;             // probe.h

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gelenk
