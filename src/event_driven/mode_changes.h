// SPDX-License-Identifier: BSD-3-Clause
// What happens at an instant: impacts, and the modes in which joints and contacts continue. Friction and limits of
// joints and contacts of shapes are decided on together; where there are no contacts, joints alone.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "event_driven/contact_modes.h"
#include "event_driven/impact_equations.h"
#include "event_driven/impact_order.h"
#include "event_driven/joint_changes.h"
#include "event_driven/joint_impacts.h"
#include "event_driven/joint_latches.h"
#include "event_driven/mode_decisions.h"
#include "event_driven/mode_equations.h"

namespace gelenk {

class ModeChanges {
 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    ModeEquations& equations;
    EventLog& log;
    LockModes& joints;
    ContactModes& contacts;
    int first_indicator = 0;  // number of indicators in the log before those of contacts
  };
  explicit ModeChanges(const Context& context);

  // Determines the modes of joints from the state alone; those of contacts when the next step begins.
  void start(double t, const double* y);
  // The same of joints where velocities have jumped, after LockModes::release(); what was at rest before and has not
  // been moved but by rounding is stopped (JointChanges::stop_unmoved), and remains at rest if friction holds it.
  void restart(double t, double* y, const LockModes::State& before, double estimated_over);
  // By lock, whether its latch holds; and the refusal of those that a motion has moved (JointLatches).
  const std::vector<int>& latched() const { return joints_.state().latched; }
  void refuse_moved_latches(const std::vector<int>& latched, const double* before, const double* q) {
    latches_.refuse_moved(latched, before, q);
  }
  // Call when inputs have jumped.
  void inputs_jumped() { jumped_ = true; }
  // Brings the modes up to date where a step begins at (t, y). Returns whether velocities in y, or modes in which they
  // continue, have changed.
  bool recall(double t, double* y);
  // Enters the modes that a step at (t, y) would begin in, without recording it.
  void preview(double t, const double* y);
  // Records that an indicator of contacts has changed its sign.
  void found_contact_event(int indicator, bool positive);
  // Enters the modes that follow from the events found; impacts and sticking change the velocities in y.
  void change(double t, double* y);

  // After the indicators of joints and contacts: where what is at rest or closed seems to give way, although redundant
  // forces can be distributed so that it does not, corrects them.
  void redistribute(double t, const double* y, double* joints, double* contacts);
  // Whether the forces of the last accelerations are the only ones that have their effect.
  bool are_forces_unique() const { return !redistributed_ && contact_equations_.are_unique(); }
  // Records the contact forces of the last accelerations, at (t, y), with which all contacts are open from then on;
  // where forces are redundant, within the laws.
  void record_outputs(double t, const double* y);

  const std::string& refusal() const { return refusal_; }
  const ModeCounts& counts() const { return counts_; }  // of contacts
  void serialize(Archive& archive);

 private:
  void start_joints(double t, const double* y, bool keeps_latches);
  bool is_contact_doubtful(double t, const double* y);
  bool is_consistent(double t, const double* y);
  void determine(double t, double* y);
  void stop_returning(double t, double* y, const LockModes::State& before);
  void refuse_ends(double t);
  bool load_signs_changed();
  bool seize(double t, double* y, bool is_doubtful);

  void strike(double t, double* y, const std::vector<int>& returning, const LockModes::State& before);
  // What is known before an impact: what is struck of joints, the accelerations with what is kept at rest, of what is
  // struck away from it, too, and the forces that keep joints at rest.
  struct BeforeImpact {
    std::vector<JointImpacts::Struck> joints;
    std::vector<double> vdot{}, holding{};
    Eigen::VectorXd accelerations{};
  };
  bool is_lost(std::size_t i, const BeforeImpact& before, const ImpactEquations& impact) const;
  bool end_series(const BeforeImpact& before, ImpactEquations& impact);
  void record_impacts(double t, const double* y, const std::vector<int>& candidates, const ImpactEquations& impact,
                      bool found, int other);

  bool decide(double t, const double* y, Recording records, ModeDecisions::Asked asked = ModeDecisions::Asked::all);
  bool decide_or_seize(double t, double* y);
  bool enter(double t, ModeDecisions::Modes next, Recording records);
  void record_doubt(double t);
  bool enter_contacts(std::vector<CandidateMode> next, Recording records);
  void record_contact_changes(double t, const std::vector<CandidateMode>& before);
  void finish(double* y);
  void stop_joints(double* y);
  bool exceed_laws();

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  ModeEquations& equations_;
  EventLog& log_;
  int first_indicator_;
  ContactModes& contacts_;
  ContactEquations& contact_equations_;
  JointChanges joints_;
  JointImpacts joint_impacts_;
  JointLatches latches_;
  ImpactOrder order_;
  ModeDecisions decisions_;
  std::vector<Trigger> triggered_;  // by candidate
  bool started_ = true, jumped_ = false;
  // Whether forces of the last indicators hold only as others that have the same effect: what those of an evaluation
  // are beyond their limits says nothing.
  bool redistributed_ = false;
  ModeCounts counts_;
  std::string refusal_;
  std::vector<double> vdot_, before_, unstopped_;
  double struck_acceleration_ = 0;               // the largest one where something is struck at this instant
  std::vector<double> load_indicators_;          // of the loads of meshes
  std::vector<int> load_signs_;                  // where a step began last
  std::vector<double> checked_, checked_rates_;  // indicators where inputs have jumped
  std::unique_ptr<bool[]> expected_;
};

}  // namespace gelenk
