// SPDX-License-Identifier: BSD-3-Clause
// An island, a part of a scene without coupling to the rest: its equations, state and integrator.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "event_driven/run_counts.h"
#include "formulation/formulation.h"
#include "formulation/recorded_motion.h"
#include "integrator/integrator.h"
#include "kinematics/loads.h"
#include "outputs/outputs.h"
#include "preparation/preparation.h"
#include "simulation/replay.h"
#include "simulation/state_force_reader.h"

namespace gelenk {

// Whether prescribed motions alone give the positions of an island at any time, so that nothing is integrated.
bool is_kinematic(const Scene& scene, const PreparedIsland& prepared, Formulation& equations);

// Not movable: its parts refer to each other.
class Island {
 public:
  // u: all inputs of the scene, evaluated at the time of each evaluation. time: start time [s].
  Island(const Scene& scene, PreparedIsland prepared, Loads loads, Inputs& u, double time);

  // Gives rates of element states the forces that they name. of: must outlive it; index: of this island.
  void read_forces(const Outputs& of, int index) {
    if (!loads_.rates_read_forces()) return;
    force_reader_.emplace(of, index, mechanism(), loads_, dynamics_->readings());
    equations_->rates_of_forces().read_by(*force_reader_);
  }
  // Creates the integrator. tolerance: relative.
  void start_integrator(double tolerance);
  // Advances to `end` [s], or to the end of the first integrator step after which max_evaluations is exceeded; returns
  // the time reached. continues: resumes an advance that ended early, without resetting anything. Throws
  // IntegrationError and SingularMass; the caller must then call roll_back().
  double advance(double end, long max_evaluations, bool continues = false);
  // Returns to the state before the last advance(), with all memory, as if that had not been made. For a method with a
  // history, to the state at its last restart: the caller then calls replay() for each leg of the path returned, with
  // the inputs of that step, and finish_replay().
  ReplayPath roll_back();

  // Writes or reads the state and all memory between steps. For a method with a history, that at its last restart: the
  // reader then calls replay() for each leg of replay_path(), with the inputs of that step, and finish_replay(). Throw
  // std::invalid_argument for invalid data; the island must then not be used.
  void serialize(Archive& archive);
  ReplayPath replay_path() const {
    return {has_history() ? replay_.legs : std::vector<ReplayStep>{}, evaluations(), inputs_jumped_, shown_};
  }
  void replay(const ReplayStep& leg);
  void finish_replay(const ReplayPath& replay_path, double time);
  const Integrator* integrator() const { return integrator_.get(); }  // null if nothing can move

  double time() const { return time_; }  // s
  // Call if an input has changed that outputs show, but that does not act.
  void outputs_changed() { forget_outputs(); }
  void inputs_changed(bool jump) {
    inputs_jumped_ = inputs_jumped_ || jump;
    inputs_touched_ = true;
    forget_outputs();
    shown_ = false;
  }
  // Exchanges the loads for those of the same scene with other numbers.
  void swap_loads(Loads& loads) {
    std::swap(loads_, loads);
    dynamics_->loads_changed();
    program_.loads_changed();
    inputs_changed(true);
    loads_changed_ = true;
    if (has_history()) discard_history();  // a replay with the new numbers would end elsewhere
  }

  // Evaluates the equations up to the stage that an output requires.
  void realize(Stage stage);
  // What hinders the motion at the present state; empty: nothing is known.
  std::string obstacle() {
    forget_outputs();
    return equations_->obstacle(y_.data());
  }
  // Of the forces that outputs show; it evaluates the equations as they do.
  LawAudit law_audit();
  const Reading& reading() const { return *reading_; }
  const PreparedIsland& prepared() const { return prepared_; }
  const Loads& loads() const { return loads_; }
  Dynamics& dynamics() { return *dynamics_; }
  Formulation& formulation() const { return *equations_; }
  // Prescribed values and derivatives of all coordinate rows at time() (Targets::derivatives).
  std::vector<MotionLaw::Derivatives> targets() const;

  RunCounts counts() const;
  const EventLog& events() const { return events_; }

 private:
  friend class Probe;
  friend class Placement;
  friend class ExchangedIsland;
  friend class RepeatedStart;

  // Exchanges the loads before another run, and then begins it as if the island had just been made with them, with the
  // inertias of the links of `like` and with this mobility. initial: an archive of the state in which an island of the
  // same start begins.
  void renew_loads(Loads& loads) {
    std::swap(loads_, loads);
    dynamics_->loads_changed();
  }
  void begin_again(Archive& initial, const Mechanism& like, const MobilityAnalysis& mobility);
  // Before a run that begins at the present state (RecordedMotion).
  void record_equations();

  // Changes the state by (dq, dv) at `time`, and closes the loops there by the smallest change in the mass metric.
  // Returns false if that fails; the island must then be placed elsewhere. Steps cannot be made afterwards.
  bool place(const Eigen::VectorXd& change, double time);
  // (q, v), and the coordinates of the cut joints with full turns counted.
  struct Position {
    Eigen::VectorXd y;
    std::vector<double> cut_q;
  };
  Position position() const;
  void place(const Position& at, double time);
  // Enters the modes of friction and limits of the same island of another simulation.
  void take_modes(const Island& other);
  // Makes the next step begin where the island was placed, as that of the other one does.
  void start_again(const Island& other);

  bool may_have_history() const { return integrator_ && integrator_->may_have_history(); }
  bool will_have_history() const { return integrator_ && integrator_->will_have_history(); }
  bool has_history() const { return integrator_ && integrator_->has_history(); }
  const Mechanism& mechanism() const { return prepared_.mechanism; }
  long evaluations() const { return dynamics_->evaluations() - evaluations_before_; }
  std::vector<std::array<std::string, 2>> event_texts() const;
  void warm_up(double step);
  void reserve(std::size_t words);
  void keep_start();
  void evaluate_outputs();
  void realize_named(Stage stage);
  void forget_outputs() {
    realized_ = Stage::position;
    evaluated_ = false;
  }
  // Throws IntegrationError if the forces at the end of an advance break the laws of friction, limits or contacts.
  void audit();
  void discard_history();
  void make_reading();
  void remember(const ReplayStep& leg, bool continues, bool whole);
  void enforce_given_motions();
  void carry_along();

  const Scene& scene_;
  PreparedIsland prepared_;
  Loads loads_;
  double best_pivot_ratio_;  // FormulationOptions
  std::unique_ptr<Dynamics> dynamics_;
  RecordedMotion program_;
  EventLog events_;
  std::unique_ptr<Formulation> equations_;
  std::unique_ptr<Integrator> integrator_;  // null if nothing can move
  double time_;
  std::vector<double> y_, vdot_;
  std::vector<double> rates_, values_;  // of the element states and the named expressions, if they have been realized
  std::optional<Reading> reading_;
  std::optional<StateForceReader> force_reader_;  // none: no rate of an element state names forces
  bool follows_ = false;                          // whether an input prescribes a coordinate
  // Prescribed motions up to which the state was advanced (Drives::targets_at).
  std::vector<double> followed_, drives_;
  Stage realized_ = Stage::position;  // of dynamics_, for the present state and inputs
  bool evaluated_ = false;            // outputs that depend on accelerations have been, at the present state
  bool shown_ = false;                // outputs of this state and these inputs have been evaluated, which counts once
  bool inputs_jumped_ = false, loads_changed_ = false;
  bool inputs_touched_ = false;  // a number has changed since the last advance
  // Where the last advance() began.
  struct Start {
    double time = 0;       // s
    long evaluations = 0;  // of the run
    bool jumped = false;   // inputs_jumped_
    bool shown = false;
    std::size_t legs = 0;       // of the history
    long last_evaluations = 0;  // of the last of them
  };
  Start start_;
  ReplayHistory replay_;
  std::size_t inputs_of_scene_;
  long evaluations_before_ = 0;  // evaluations before the run, which are not counted
};

}  // namespace gelenk
