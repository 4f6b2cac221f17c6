// SPDX-License-Identifier: BSD-3-Clause
// Steps of a mechanism with contacts, friction and limits by impulses, and the forces that outputs show between them.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "event_driven/lock_modes.h"
#include "formulation/drives.h"
#include "formulation/state_steps.h"
#include "time_stepping/time_stepper.h"

namespace gelenk {

class ImpulseSteps {
 public:
  // All must outlive it. locks: released.
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    const Loads& loads;
    Drives& drives;
    LockModes& locks;
    EventLog& events;
  };
  explicit ImpulseSteps(const Context& context) : with_(context) {}

  // As ImpulseEquations.
  bool are_required() const { return with_.mechanism.touches(); }
  void use(ImpulseAccuracy accuracy);
  bool are_available() const { return stepper_ != nullptr; }
  void start(double t, double h, const double* y);
  bool step(double t, double h, double* y);
  LockModes& locks() const { return with_.locks; }
  EventLog& events() const { return with_.events; }
  const Loads& loads() const { return with_.loads; }
  TimeStepper& stepper() { return *stepper_; }
  const double* smooth_accelerations() const { return stepper_->smooth_accelerations().data(); }
  double highest_frequency(double t, const double* y);

  // Forgets the forces of the last step.
  void forget() {
    if (are_available()) stepper_->forget();
  }
  // At the start of each part of a communication step; continues: of a later one.
  void begin_part(bool continues) {
    if (are_available()) stepper_->begin_part(continues);
  }
  // Why the last step has failed; empty: it has not.
  std::string failure() const { return are_available() ? stepper_->failure() : ""; }
  TimeStepper::Solved solved() const { return are_available() ? stepper_->solved() : TimeStepper::Solved{}; }
  std::size_t contact_points() const { return are_available() ? stepper_->state().contacts.size() : 0; }
  long changes() const { return are_available() ? stepper_->changes() : 0; }
  void record(std::vector<RecordedProblem>* to) {
    if (are_available()) stepper_->record(to);
  }
  // Of joints, in the last step.
  std::span<const LockForces> lock_forces() const { return stepper_->state().locks; }
  // What outputs of contacts show; null: otherwise.
  ContactReadings* readings() const { return stepper_.get(); }
  void serialize(Archive& archive);

  // During its lifetime, solve() applies the mean forces of the last step to the bodies at y.
  class AppliedForces {
   public:
    AppliedForces(ImpulseSteps& steps, const double* y);
    ~AppliedForces();
    AppliedForces(const AppliedForces&) = delete;
    AppliedForces& operator=(const AppliedForces&) = delete;

   private:
    ContactRows& rows_;
  };

 private:
  Context with_;
  bool begin_states(double h, const double* y);
  bool finish_states(double h, double* y);
  double change_of_accelerations(const double* y, const std::vector<double>& x);

  std::unique_ptr<TimeStepper> stepper_;  // null: only modes between events
  std::unique_ptr<StateSteps> states_;    // null: there are no element states
  int size_ = 0;                          // of y
  std::vector<double> trial_;
  std::vector<Spatial::Force> applied_;  // by link, about the origin of the root frame
  // Of the search for the fastest vibration: its mode, the last one a good guess, and workspace.
  std::vector<double> vibration_, displacement_, rest_, at_rest_, displaced_;
};

}  // namespace gelenk
