// SPDX-License-Identifier: BSD-3-Clause
// One part of a scene that is solved by itself: its equations, its state, its integrator.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formulation/formulation.h"
#include "integrator/integrator.h"
#include "outputs/outputs.h"
#include "preparation/preparation.h"
#include "simulation/replay.h"

namespace gelenk {

// Of a run, up to now.
struct RunCounts {
  long steps = 0, rejected_steps = 0, evaluations = 0, jacobians = 0, events = 0, singular_positions = 0;
};

// Not movable: its parts refer to each other.
class Island {
 public:
  // u: all inputs of the scene, taken at every evaluation to its time. time [s]: of the start.
  Island(const Scene& scene, PreparedIsland prepared, Loads loads, Inputs& u, double time);

  // tolerance: overrides the scene's when positive.
  void start_integrator(double tolerance);
  // To `end`, or to the end of the first of its steps by which so many evaluations are budget_exhausted; returns the
  // time reached. Throws IntegrationError, SingularMass; roll_back() is due then. goes_on: that was cut short, and
  // nothing is set anew.
  double advance(double end, long most_evaluations, bool continues = false);
  // Back to before the last advance().
  void roll_back();

  // Where it stands and all it carries from one step to the next; with a history, where that began: then go_again()
  // along way(), under the inputs of then, and arrive(). Throw std::invalid_argument; it is undefined then.
  void serialize(Archive& archive);
  ReplayPath replay_path() const { return {replay_.legs, evaluations(), inputs_jumped_}; }
  void replay(const ReplayStep& leg);
  void finish_replay(const ReplayPath& replay_path, double time);
  const Integrator* integrator() const { return integrator_.get(); }  // none where nothing moves

  double time() const { return time_; }  // s
  void inputs_changed(bool jump) {
    inputs_jumped_ = inputs_jumped_ || jump;
    realized_ = Stage::position;
  }
  // loads: of the same scene with other numbers; in serialize, those so far.
  void swap_loads(Loads& loads) {
    std::swap(loads_, loads);
    inputs_changed(true);
    if (has_history()) discard_history();  // what has led here would not lead here any more
  }

  // Brings the equations up to what outputs need.
  void realize(Stage stage);
  Reading reading() const;
  const PreparedIsland& prepared() const { return prepared_; }
  const Loads& loads() const { return loads_; }
  Dynamics& dynamics() { return *dynamics_; }
  const Formulation& formulation() const { return *equations_; }
  // Of all coordinate rows, where it stands (Targets::derivatives).
  std::vector<MotionLaw::Derivatives> targets() const;

  RunCounts counts() const;
  const EventLog& events() const { return events_; }

 private:
  friend class Probe;

  bool may_have_history() const { return integrator_ && integrator_->may_have_history(); }
  bool will_have_history() const { return integrator_ && integrator_->will_have_history(); }
  bool has_history() const { return integrator_ && integrator_->has_history(); }
  const Mechanism& mechanism() const { return prepared_.mechanism; }
  long evaluations() const { return dynamics_->evaluations() - evaluations_before_; }
  std::vector<std::array<std::string, 2>> event_texts() const;
  void warm_up(double step);
  void make_room(std::size_t words);
  void discard_history();
  void remember(const ReplayStep& leg, bool continues, bool whole);
  void enforce_given_motions();
  const double* q() const { return y_.data(); }
  const double* v() const { return y_.data() + mechanism().nq; }

  const Scene& scene_;
  PreparedIsland prepared_;
  Loads loads_;
  std::unique_ptr<Dynamics> dynamics_;
  EventLog events_;
  std::unique_ptr<Formulation> equations_;
  std::unique_ptr<Integrator> integrator_;  // none where nothing moves
  double time_;
  std::vector<double> y_, vdot_;
  double backup_time_;
  std::vector<double> backup_;
  bool follows_ = false;                                     // some row follows an input
  std::vector<double> followed_, backup_followed_, drives_;  // what the rows were followed to (Drives::targets_at)
  Stage realized_ = Stage::position;                            // what dynamics_ holds for the present state and inputs
  bool inputs_jumped_ = false;
  ReplayHistory replay_;
  std::size_t inputs_of_scene_;
  long evaluations_before_ = 0;  // made to prepare the run
};

}  // namespace gelenk
